// The canvas: one camera for one or two views side by side, each a scene with its own light.

import {
  Box3,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  NeutralToneMapping,
  PCFShadowMap,
  PerspectiveCamera,
  Quaternion,
  Raycaster,
  Scene,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import type { Camera, Frame, SceneModel } from '../scene';
import { Bodies } from './bodies';
import { boundingBox } from './bounds';
import { Ground } from './ground';
import { Arrows, Lines } from './marks';
import { Strings } from './strings';
import { SCENERY, type ColorMode, type Theme } from './palette';

/** `low`: no shadows, no grain, one pixel for one: for slow machines and quick tests. */
export type Quality = 'high' | 'low';

export interface Ray {
  /** Which view the pointer is in. */
  view: number;
  origin: Vector3;
  direction: Vector3;
}

/** One scene on the canvas. */
export class View {
  readonly scene = new Scene();
  readonly arrows = new Arrows();
  readonly lines = new Lines();
  private readonly sun = new DirectionalLight();
  private readonly sky = new HemisphereLight();
  private bodies?: Bodies;
  private ground?: Ground;
  private strings?: Strings;
  private theme: Theme = 'light';
  private quality: Quality;

  constructor(quality: Quality) {
    this.quality = quality;
    this.sun.castShadow = quality === 'high';
    this.sun.shadow.mapSize.set(2048, 2048);
    this.sun.shadow.bias = -0.0003;
    this.sun.shadow.normalBias = 0.02;
    this.scene.add(this.sun, this.sun.target, this.sky, this.arrows.group, this.lines.group);
  }

  /** Another scene, or other bodies in the same. */
  show(model: SceneModel, frame: Frame, around: Sphere, cell: number): void {
    this.bodies?.dispose();
    this.ground?.dispose();
    this.strings?.dispose();
    for (const old of [this.bodies?.group, this.ground?.group, this.strings?.mesh]) if (old) this.scene.remove(old);
    this.bodies = new Bodies(model, this.quality === 'high');
    this.ground = new Ground(model, 40 * around.radius, cell);
    this.strings = new Strings(model);
    this.scene.add(this.bodies.group, this.ground.group, this.strings.mesh);
    this.light(new Vector3(...model.up), around);
    this.setTheme(this.theme);
    this.update(frame, 'stone');
  }

  private light(up: Vector3, around: Sphere): void {
    // From the left, behind the viewer of most scenes, 55° high.
    const side = new Vector3(-0.45, 0.9, 0.55).normalize();
    if (Math.abs(up.z) > 0.5) side.set(-0.45, -0.55, 0.9).normalize();
    const reach = 1.5 * around.radius;
    this.sun.position.copy(around.center).addScaledVector(side, 3 * reach);
    this.sun.target.position.copy(around.center);
    const camera = this.sun.shadow.camera;
    camera.left = camera.bottom = -reach;
    camera.right = camera.top = reach;
    camera.near = 0.1 * reach;
    camera.far = 7 * reach;
    camera.updateProjectionMatrix();
    this.sun.shadow.radius = 2.5;
    this.sky.position.copy(up);
    this.scene.fog = new Fog(0, 4 * around.radius + 10, 22 * around.radius + 30);
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    const scenery = SCENERY[theme];
    this.scene.background = new Color(scenery.sky);
    this.scene.fog?.color.set(scenery.sky);
    this.sun.intensity = scenery.sun;
    this.sky.intensity = scenery.fill;
    this.sky.color.set(scenery.skyLight);
    this.sky.groundColor.set(scenery.groundLight);
    this.ground?.theme(scenery);
  }

  update(frame: Frame, mode: ColorMode): void {
    this.bodies?.update(frame, mode);
    this.ground?.update(frame);
    this.strings?.update(frame);
  }

  setOpacity(opacity: number): void {
    this.bodies?.setOpacity(opacity);
  }

  dispose(): void {
    this.bodies?.dispose();
    this.ground?.dispose();
    this.strings?.dispose();
    this.arrows.dispose();
    this.lines.dispose();
    this.sun.dispose();
  }
}

export class Stage {
  readonly camera = new PerspectiveCamera(42, 1, 0.01, 10000);
  readonly views: View[] = [];
  controls: OrbitControls;
  private readonly renderer: WebGLRenderer;
  private readonly canvas: HTMLCanvasElement;
  private readonly quality: Quality;
  private theme: Theme = 'light';

  constructor(canvas: HTMLCanvasElement, quality: Quality) {
    this.canvas = canvas;
    this.quality = quality;
    this.renderer = new WebGLRenderer({ canvas, antialias: quality === 'high', powerPreference: 'high-performance' });
    this.renderer.shadowMap.enabled = quality === 'high';
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.toneMapping = NeutralToneMapping;
    this.renderer.setScissorTest(true);
    this.controls = this.makeControls();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.enableDamping = true;
    controls.dampingFactor = 0.12;
    controls.maxPolarAngle = 0.53 * Math.PI;
    return controls;
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    this.renderer.setPixelRatio(this.quality === 'high' ? Math.min(window.devicePixelRatio, 2) : 1);
    this.renderer.setSize(Math.max(clientWidth, 1), Math.max(clientHeight, 1), false);
  }

  setViews(count: number): void {
    while (this.views.length > count) this.views.pop()?.dispose();
    while (this.views.length < count) {
      const view = new View(this.quality);
      view.setTheme(this.theme);
      this.views.push(view);
    }
  }

  setTheme(theme: Theme): void {
    this.theme = theme;
    this.views.forEach((view) => view.setTheme(theme));
  }

  /** Looks at a scene from where it says, or from in front, as near as it fits the window. */
  look(model: SceneModel, frame: Frame, hint?: Camera | null): Sphere {
    const box = boundingBox(model, frame);
    const around = box.getBoundingSphere(new Sphere());
    const up = new Vector3(...model.up);
    const target = hint ? new Vector3(...hint.target) : around.center.clone();
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), up);
    const front = new Vector3(0.6, 0.45, 1).normalize().applyQuaternion(turn);
    const eye = hint ? new Vector3(...hint.position) : front.multiplyScalar(3 * around.radius).add(target);
    this.controls.dispose();
    this.camera.up.copy(up);
    this.camera.near = 0.002 * around.radius;
    this.camera.far = 200 * around.radius + 200;
    this.camera.position.copy(eye);
    this.camera.lookAt(target);
    this.fit(box, target);
    this.controls = this.makeControls();
    this.controls.target.copy(target);
    this.controls.update();
    return around;
  }

  /** Steps back until the box is in the window, or nearer while it is small. */
  private fit(box: Box3, target: Vector3): void {
    this.shapeCamera();
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(
      (i) => new Vector3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z),
    );
    /** 1: the box reaches the rim of the window. */
    const filled = (): number => {
      this.camera.updateMatrixWorld();
      const parts = corners.map((corner) => {
        const { x, y, z } = corner.clone().project(this.camera);
        // Bar and labels are at the top.
        return z > 1 ? 10 : Math.max(Math.abs(x), 1.2 * Math.abs(y));
      });
      return Math.max(...parts);
    };
    const move = (factor: number): void => void this.camera.position.sub(target).multiplyScalar(factor).add(target);
    for (let i = 0; i < 40 && filled() > 0.86; i++) move(1.06);
    for (let i = 0; i < 10 && filled() < 0.6; i++) move(0.95);
  }

  private shapeCamera(): void {
    const { clientWidth, clientHeight } = this.canvas;
    this.camera.aspect = clientWidth / Math.max(this.views.length, 1) / Math.max(clientHeight, 1);
    this.camera.updateProjectionMatrix();
  }

  draw(): void {
    this.controls.update();
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const part = width / Math.max(this.views.length, 1);
    this.shapeCamera();
    this.views.forEach((view, i) => {
      this.renderer.setViewport(i * part, 0, part, height);
      this.renderer.setScissor(i * part, 0, part, height);
      this.renderer.render(view.scene, this.camera);
    });
  }

  /** Around the target by angles (rad); the distance times `factor`. For keys: the mouse has its own way. */
  orbit(around: number, upward: number, factor: number): void {
    const { target } = this.controls;
    const arm = this.camera.position.clone().sub(target);
    const axis = new Vector3().crossVectors(arm, this.camera.up).normalize();
    const tilt = arm.angleTo(this.camera.up);
    const allowed = Math.min(Math.max(tilt - upward, 0.05), this.controls.maxPolarAngle);
    arm.applyAxisAngle(axis, tilt - allowed).applyAxisAngle(this.camera.up, around);
    this.camera.position.copy(target).addScaledVector(arm, factor);
    this.controls.update();
  }

  /** From the eye through a point of the window. */
  ray(clientX: number, clientY: number): Ray {
    const box = this.canvas.getBoundingClientRect();
    const count = Math.max(this.views.length, 1);
    const across = Math.min(Math.max((clientX - box.left) / box.width, 0), 0.9999) * count;
    const view = Math.floor(across);
    const point = new Vector2(2 * (across - view) - 1, 1 - (2 * (clientY - box.top)) / box.height);
    const caster = new Raycaster();
    caster.setFromCamera(point, this.camera);
    return { view, origin: caster.ray.origin, direction: caster.ray.direction };
  }
}
