// What runs: one scene in one or two configurations, in step.

import { Sphere, Vector3, Quaternion } from 'three';
import { POSE, type Frame } from '../scene';
import type { Ray, Stage } from '../view/stage';
import type { ColorMode } from '../view/palette';
import { World, type Source } from './engine';

export const OVERLAYS = [
  { id: 'contacts', name: 'Contacts', doc: 'Points, and arrows along the normals as long as their impulse λ' },
  { id: 'rows', name: 'Constraint rows', doc: 'Normal (red) and friction (blue) rows, and the bodies they couple' },
  { id: 'joints', name: 'Joint frames', doc: 'Frames on both bodies; a red line is the error' },
  { id: 'centers', name: 'Centers of mass', doc: '' },
  { id: 'bounds', name: 'Bounds (AABB)', doc: 'Fat boxes of the broad phase' },
  { id: 'velocities', name: 'Velocities', doc: 'Linear green, angular magenta' },
] as const;

export type OverlayName = (typeof OVERLAYS)[number]['id'];

/** One configuration of the scene. */
export interface Side {
  world: World;
  frame: Frame;
  /** Options before anything was changed. */
  base: Map<string, string>;
  options: Map<string, string>;
  saved?: Uint8Array;
}

/** Changes of options as [path, value]. */
export type Changes = [string, string][];

/** Milliseconds of a frame that stepping may take: drawing needs the rest. */
const BUDGET = 13;
/** m/s: 1/60 s of gravity, for scenes without. */
const GRAVITY_STEP = 9.81 / 60;

export class Session {
  sides: Side[] = [];
  source: Source;
  playing = false;
  speed = 1;
  colorMode: ColorMode = 'stone';
  readonly overlays = new Set<OverlayName>();
  ball = { speed: 25, radius: 0.4, density: 2000 };
  /** Simulated over real time of the last frames. */
  rate = 0;
  /** Seconds of real time that are not simulated yet. */
  private behind = 0;
  private around = new Sphere();
  private held: { offset: Vector3; start: Vector3 }[] = [];
  private readonly stage: Stage;
  /** Something other than a step changed: controls, scene, number of sides. */
  onchange: () => void = () => {};
  onstep: () => void = () => {};

  constructor(stage: Stage, source: Source, changes: Changes[]) {
    this.stage = stage;
    this.source = source;
    this.load(source, changes);
  }

  /** Builds the scene once for each list of changes; if it cannot be built nothing changes. */
  load(source: Source, changes: Changes[]): void {
    const sides: Side[] = [];
    try {
      for (const list of changes) {
        const world = new World(source);
        const base = world.options();
        sides.push({ world, frame: world.frame(), base, options: base });
        // Setting a number of a technique switches it on: switches come last.
        const ordered = [...list].sort(([a], [b]) => rank(a) - rank(b));
        for (const [path, value] of ordered) world.setOption(path, value);
        const side = sides[sides.length - 1];
        if (side) side.options = world.options();
      }
    } catch (error) {
      sides.forEach((side) => side.world.free());
      throw error;
    }
    this.sides.forEach((side) => side.world.free());
    this.sides = sides;
    this.source = source;
    this.behind = 0;
    this.held = [];
    this.stage.setViews(sides.length);
    this.look();
    this.show();
    this.onchange();
  }

  /** Looks at the scene from where it says, as near as it fits the window. */
  look(): void {
    const { world, frame } = this.first;
    this.around = this.stage.look(world.model, frame, world.about.camera);
  }

  get first(): Side {
    const side = this.sides[0];
    if (!side) throw new Error('no scene is loaded');
    return side;
  }

  get dt(): number {
    return this.first.world.about.dt;
  }

  private show(): void {
    const cell = this.first.world.about.length_scale;
    this.sides.forEach((side, i) => this.stage.views[i]?.show(side.world.model, side.frame, this.around, cell));
    this.refresh();
  }

  /** Reads the state of all sides and hands it to the views. */
  refresh(): void {
    this.sides.forEach((side, i) => {
      const view = this.stage.views[i];
      if (!view) return;
      const changed = side.world.refresh();
      side.frame = side.world.frame();
      if (changed) view.show(side.world.model, side.frame, this.around, side.world.about.length_scale);
      view.update(side.frame, this.colorMode);
      const inside = ['contacts', 'rows', 'joints', 'centers'].some((name) => this.overlays.has(name as OverlayName));
      view.setOpacity(inside ? 0.55 : 1);
      const size = side.world.about.length_scale;
      view.arrows.update(
        this.overlays.has('contacts') ? side.world.contacts() : new Float32Array(),
        0.8 * size,
        this.weightStep(side),
      );
      view.lines.update(this.lines(side));
    });
  }

  /** What gravity adds to the speed of a body in a step: an arrow of this impulse is nearly as long as a body. */
  private weightStep(side: Side): number {
    const gravity = JSON.parse(side.options.get('gravity') ?? '[]') as number[];
    return Math.hypot(...gravity) * this.dt || GRAVITY_STEP;
  }

  private lines(side: Side): Float32Array {
    const parts = OVERLAYS.filter(({ id }) => id !== 'contacts' && this.overlays.has(id)).map(({ id }) => side.world.lines(id));
    const ends = side.world.grabbed();
    if (ends.length === 6) {
      const color = [0.9, 0.25, 0.15, 1];
      parts.push(Float32Array.from([...ends.subarray(0, 3), ...color, ...ends.subarray(3, 6), ...color]));
    }
    const all = new Float32Array(parts.reduce((sum, p) => sum + p.length, 0));
    let at = 0;
    for (const part of parts) {
      all.set(part, at);
      at += part.length;
    }
    return all;
  }

  /** Advances by real time, in seconds, as far as the machine keeps up. */
  advance(seconds: number): void {
    if (!this.playing) return;
    this.behind = Math.min(this.behind + seconds * this.speed, 0.25);
    const start = performance.now();
    let steps = 0;
    while (this.behind >= this.dt && performance.now() - start < BUDGET) {
      this.behind -= this.dt;
      this.stepAll();
      steps++;
    }
    if (this.behind >= this.dt) this.behind = 0;
    const rate = seconds > 0 ? (steps * this.dt) / seconds : 0;
    this.rate += 0.05 * (rate - this.rate);
    if (steps > 0) this.refresh();
  }

  step(): void {
    this.stepAll();
    this.refresh();
  }

  private stepAll(): void {
    for (const side of this.sides) side.world.step(this.dt);
    this.onstep();
  }

  reset(): void {
    for (const side of this.sides) side.world.reset();
    this.behind = 0;
    this.held = [];
    this.refresh();
    this.onchange();
  }

  setOption(side: number, path: string, value: string): void {
    const changed = this.sides[side];
    if (!changed) return;
    try {
      changed.world.setOption(path, value);
    } finally {
      changed.options = changed.world.options();
      this.onchange();
    }
  }

  /** The body under the pointer is held; in the other configuration too, at the same place of the same body. */
  grab(ray: Ray): Vector3 | null {
    const side = this.sides[ray.view];
    const hit = side?.world.pick(ray.origin, ray.direction);
    if (!side || !hit) return null;
    const [place, ...at] = hit;
    const point = new Vector3(...at);
    const local = point.clone().sub(origin(side.frame, place)).applyQuaternion(turn(side.frame, place).invert());
    this.held = this.sides.map((other) => {
      const start = local.clone().applyQuaternion(turn(other.frame, place)).add(origin(other.frame, place));
      other.world.grab(place, start.x, start.y, start.z);
      return { start, offset: start.clone().sub(point) };
    });
    return point;
  }

  drag(target: Vector3): void {
    this.sides.forEach((side, i) => {
      const at = target.clone().add(this.held[i]?.offset ?? new Vector3());
      side.world.drag(at.x, at.y, at.z);
    });
    if (!this.playing) this.refresh();
  }

  release(): void {
    this.sides.forEach((side) => side.world.release());
    this.held = [];
    this.refresh();
  }

  shoot(ray: Ray): void {
    const size = this.first.world.about.length_scale;
    const velocity = ray.direction.clone().multiplyScalar(this.ball.speed * Math.sqrt(size));
    const start = ray.origin.clone().addScaledVector(ray.direction, 2 * this.ball.radius * size);
    for (const side of this.sides) side.world.shoot(start, velocity, this.ball.radius * size, this.ball.density);
    this.refresh();
  }

  save(): void {
    for (const side of this.sides) side.saved = side.world.snapshot();
    this.onchange();
  }

  restore(): void {
    for (const side of this.sides) if (side.saved) this.restoreSide(side, side.saved);
    this.refresh();
    this.onchange();
  }

  /** Both sides continue from a file. */
  restoreFrom(bytes: Uint8Array): void {
    for (const side of this.sides) this.restoreSide(side, bytes);
    this.refresh();
    this.onchange();
  }

  private restoreSide(side: Side, bytes: Uint8Array): void {
    side.world.restore(bytes);
    side.options = side.world.options();
  }
}

/** `solver` itself first, then numbers, then switches. */
function rank(path: string): number {
  return path === 'solver' ? 0 : path.endsWith('.enabled') ? 2 : 1;
}

function origin(frame: Frame, place: number): Vector3 {
  return new Vector3().fromArray(frame.poses, place * POSE);
}

function turn(frame: Frame, place: number): Quaternion {
  return new Quaternion().fromArray(frame.poses, place * POSE + 3);
}
