// The engine: loaded once, then typed answers instead of JSON.

import init, * as wasm from '../../generated/ishigaki.js';
import packed from 'virtual:engine';
import type { Camera, Frame, SceneModel } from '../scene';
import { unpack } from '../ui/bytes';

export interface Parameter {
  name: string;
  default: number;
  least: number;
  most: number;
  unit: string;
  whole: boolean;
  doc: string;
}

export interface SceneInfo {
  name: string;
  summary: string;
  parameters: Parameter[];
}

export type ControlKind = 'switch' | 'whole' | 'number' | 'vector' | { choice: [name: string, doc: string][] };

export interface Control {
  path: string;
  kind: ControlKind;
  default: string;
  doc: string;
  group_doc: string;
}

export interface About {
  name: string;
  description: string;
  dt: number;
  steps: number;
  camera: Camera | null;
  warnings: string[];
  length_scale: number;
}

/** What a step did; see `StepReport` of the engine. */
export interface Report {
  step: number;
  time: number;
  stages: [name: string, seconds: number][];
  rejected: string | null;
  bodies: number;
  asleep: number;
  contacts: number;
  frozen: number;
  rows: number;
  islands: number;
  sweeps: number;
  residual: number;
  residual_by_sweep: number[];
  max_penetration: number;
  max_joint_error: number;
  max_speed: number;
  angular_momentum: [number, number, number];
  kinetic_energy: number;
  potential_energy: number;
  non_finite: unknown[];
}

export type Source = { scene: string; parameters: Record<string, number> } | { file: string; text: string };

export interface Engine {
  scenes: SceneInfo[];
  controls: Control[];
  /** All options with each preset of the solver. */
  presets: Map<string, Map<string, string>>;
  version: string;
}

/** Numbers of a body's state: rest, height, island, speed. */
const STATE = 4;
type Columns = [Float32Array, Float32Array, Float32Array, Float32Array];

const PRESETS = ['plain', 'talk', 'default'];

export async function loadEngine(): Promise<Engine> {
  await init({ module_or_path: await unpack(packed) });
  return {
    scenes: JSON.parse(wasm.scenes()) as SceneInfo[],
    controls: JSON.parse(wasm.optionControls()) as Control[],
    presets: new Map(PRESETS.map((name) => [name, optionsOf(name)])),
    version: wasm.version(),
  };
}

function optionsOf(preset: string): Map<string, string> {
  const world = new World({ file: 'empty.json', text: '{}' });
  world.setOption('solver', preset);
  const options = world.options();
  world.free();
  return options;
}

/** A world that runs; throws an `Error` with the engine's message. */
export class World {
  readonly about: About;
  model!: SceneModel;
  report: Report;
  private readonly testbed: wasm.Testbed;
  private version = -1;

  constructor(source: Source) {
    this.testbed =
      'scene' in source
        ? wasm.Testbed.named(source.scene, JSON.stringify(source.parameters))
        : wasm.Testbed.fromFile(source.file, source.text);
    this.about = JSON.parse(this.testbed.about()) as About;
    this.report = this.readReport();
    this.refresh();
  }

  /** Reads the shapes anew if bodies came or went; `true` if they did. */
  refresh(): boolean {
    const version = this.testbed.geometryVersion();
    if (version === this.version) return false;
    this.version = version;
    this.model = JSON.parse(this.testbed.geometry()) as SceneModel;
    return true;
  }

  private readReport(): Report {
    return JSON.parse(this.testbed.report()) as Report;
  }

  step(dt: number): Report {
    this.report = JSON.parse(this.testbed.step(dt)) as Report;
    return this.report;
  }

  frame(): Frame {
    const states = this.testbed.states();
    const bodies = states.length / STATE;
    const [rest, heights, islands, speeds] = [0, 1, 2, 3].map(() => new Float32Array(bodies)) as Columns;
    for (let i = 0, at = 0; i < bodies; i++, at += STATE) {
      rest[i] = states[at] ?? 0;
      heights[i] = states[at + 1] ?? 0;
      islands[i] = states[at + 2] ?? 0;
      speeds[i] = states[at + 3] ?? 0;
    }
    return { poses: this.testbed.poses(), rest, heights, islands, speeds };
  }

  options(): Map<string, string> {
    return new Map(JSON.parse(this.testbed.options()) as [string, string][]);
  }

  setOption(path: string, value: string): void {
    this.testbed.setOption(path, value);
  }

  reset(): void {
    this.testbed.reset();
    this.report = this.readReport();
  }

  contacts(): Float32Array {
    return this.testbed.contacts();
  }

  lines(overlay: string): Float32Array {
    return this.testbed.lines(overlay);
  }

  pick(o: { x: number; y: number; z: number }, d: { x: number; y: number; z: number }): [number, number, number, number] | null {
    const hit = this.testbed.pick(o.x, o.y, o.z, d.x, d.y, d.z);
    return hit.length === 4 ? (Array.from(hit) as [number, number, number, number]) : null;
  }

  grab(place: number, x: number, y: number, z: number): boolean {
    return this.testbed.grab(place, x, y, z);
  }

  drag(x: number, y: number, z: number): void {
    this.testbed.drag(x, y, z);
  }

  release(): void {
    this.testbed.release();
  }

  grabbed(): Float32Array {
    return this.testbed.grabbed();
  }

  shoot(o: { x: number; y: number; z: number }, v: { x: number; y: number; z: number }, radius: number, density: number): void {
    this.testbed.shoot(o.x, o.y, o.z, v.x, v.y, v.z, radius, density);
  }

  snapshot(): Uint8Array {
    return this.testbed.snapshot();
  }

  restore(bytes: Uint8Array): void {
    this.testbed.restore(bytes);
    this.report = this.readReport();
  }

  /** The scene before the first step, as a scene file. */
  file(): string {
    return this.testbed.sceneFile();
  }

  hash(): string {
    return this.testbed.stateHash();
  }

  free(): void {
    this.testbed.free();
  }
}
