// Pointer: drag a body to pull it, drag anything else to look around, double-click or F to shoot.

import { Plane, Ray as Line, Vector3 } from 'three';
import type { Stage } from '../view/stage';
import type { Session } from './session';

export class Mouse {
  /** Where the pointer was last: keys shoot there. */
  private last = { x: 0, y: 0, inside: false };
  private plane: Plane | null = null;
  private readonly canvas: HTMLCanvasElement;
  private readonly stage: Stage;
  private readonly session: () => Session | null;

  constructor(canvas: HTMLCanvasElement, stage: Stage, session: () => Session | null) {
    this.canvas = canvas;
    this.stage = stage;
    this.session = session;
    // Before the camera's own listener, which must not turn while a body is pulled.
    canvas.addEventListener('pointerdown', this.down, { capture: true });
    canvas.addEventListener('pointermove', this.move);
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) canvas.addEventListener(end, this.up);
    canvas.addEventListener('pointerleave', () => (this.last.inside = false));
    canvas.addEventListener('dblclick', (event) => this.shoot(event.clientX, event.clientY));
  }

  shootAhead(): void {
    const box = this.canvas.getBoundingClientRect();
    const count = Math.max(this.stage.views.length, 1);
    if (this.last.inside) this.shoot(this.last.x, this.last.y);
    else this.shoot(box.left + box.width / (2 * count), box.top + box.height / 2);
  }

  private shoot(x: number, y: number): void {
    this.session()?.shoot(this.stage.ray(x, y));
  }

  private readonly down = (event: PointerEvent): void => {
    if (event.button !== 0 || !event.isPrimary || event.ctrlKey || event.shiftKey || event.metaKey) return;
    const point = this.session()?.grab(this.stage.ray(event.clientX, event.clientY));
    if (!point) return;
    this.plane = new Plane().setFromNormalAndCoplanarPoint(this.stage.camera.getWorldDirection(new Vector3()), point);
    this.stage.controls.enabled = false;
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.classList.add('grabbing');
  };

  private readonly move = (event: PointerEvent): void => {
    this.last = { x: event.clientX, y: event.clientY, inside: true };
    if (!this.plane) return;
    const ray = this.stage.ray(event.clientX, event.clientY);
    const target = new Line(ray.origin, ray.direction).intersectPlane(this.plane, new Vector3());
    if (target) this.session()?.drag(target);
  };

  private readonly up = (): void => {
    if (!this.plane) return;
    this.plane = null;
    this.stage.controls.enabled = true;
    this.canvas.classList.remove('grabbing');
    this.session()?.release();
  };
}
