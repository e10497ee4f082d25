// Reads recordings: docs/recording-format.md, version 1.

import type { Camera, Frame, SceneModel } from '../scene';
import { POSE, Rest } from '../scene';

const MARK = [0x89, 0x49, 0x53, 0x48, 0x49, 0x0d, 0x0a, 0x1a];
const VERSION = 1;
const HEAD = 16;
/** Tag, length and checksum of a chunk. */
const AROUND = 12;
const FRAME_HEAD = 64;
const RECORD = 40;
const CONTACT = 44;

/** What is wrong with a recording. */
export class RecordingError extends Error {}

export interface Scene extends SceneModel {
  name: string;
  engine: string;
  dt: number;
  every: number;
  contacts: boolean;
  options: { length_scale?: number; gravity?: [number, number, number] };
  camera?: Camera;
}

/** What the world reported at a frame. */
export interface Measures {
  step: number;
  time: number;
  kinetic: number;
  potential: number;
  angularMomentum: number;
  penetration: number;
  jointError: number;
  residual: number;
  contacts: number;
}

interface FrameChunk {
  key: boolean;
  /** Where its content begins in the file, and its numbers of records and contacts. */
  at: number;
  records: number;
  contacts: number;
}

const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; k++) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});

export function crc32(bytes: Uint8Array, from: number, to: number): number {
  let crc = 0xffffffff;
  for (let i = from; i < to; i++) crc = (TABLE[(crc ^ (bytes[i] ?? 0)) & 255] ?? 0) ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

export class Recording {
  readonly scene: Scene;
  /** Why the end is missing, if it is. */
  readonly cut: string | null;
  private readonly view: DataView;
  private readonly chunks: FrameChunk[];
  private readonly states: Uint32Array;
  private readonly poses: Float32Array;
  private readonly islands: Int32Array;
  private shown = -1;

  /** Throws a `RecordingError` unless at least the scene and one frame can be read. */
  constructor(bytes: Uint8Array) {
    checkHead(bytes);
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const { scene, chunks, cut } = walk(bytes, this.view);
    [this.scene, this.chunks, this.cut] = [scene, chunks, cut];
    const bodies = scene.bodies.length;
    this.states = new Uint32Array(bodies);
    this.poses = new Float32Array(POSE * bodies);
    this.islands = new Int32Array(bodies);
  }

  get length(): number {
    return this.chunks.length;
  }

  measures(frame: number): Measures {
    const { at, contacts } = this.chunk(frame);
    const f32 = (offset: number): number => this.view.getFloat32(at + offset, true);
    return {
      step: Number(this.view.getBigUint64(at + 8, true)),
      time: this.view.getFloat64(at + 16, true),
      kinetic: f32(24),
      potential: f32(28),
      angularMomentum: Math.hypot(f32(32), f32(36), f32(40)),
      penetration: f32(44),
      jointError: f32(48),
      residual: f32(52),
      contacts,
    };
  }

  /** The bodies at a frame. The arrays are used again by the next call. */
  frame(frame: number): Frame {
    this.chunk(frame);
    let first = frame;
    while (!this.chunk(first).key) first--;
    // From the frame shown last, if the way from there is shorter.
    if (this.shown >= first && this.shown <= frame) first = this.shown + 1;
    for (let i = first; i <= frame; i++) this.apply(this.chunk(i));
    this.shown = frame;
    return this.describe();
  }

  private chunk(frame: number): FrameChunk {
    const chunk = this.chunks[frame];
    if (!chunk) throw new RecordingError(`there is no frame ${frame}: the recording has ${this.length}`);
    return chunk;
  }

  private apply({ at, records }: FrameChunk): void {
    const { view } = this;
    const start = at + FRAME_HEAD;
    for (let i = 0; i < records; i++) {
      const body = view.getUint32(start + 4 * i, true);
      this.states[body] = view.getUint32(start + 4 * (records + i), true);
      this.islands[body] = view.getInt32(start + 4 * (2 * records + i), true);
      for (let k = 0; k < 3; k++) this.poses[POSE * body + k] = view.getFloat32(start + 12 * records + 4 * (3 * i + k), true);
      for (let k = 0; k < 4; k++) this.poses[POSE * body + 3 + k] = view.getFloat32(start + 24 * records + 4 * (4 * i + k), true);
    }
  }

  private describe(): Frame {
    const poses = this.poses.slice();
    const rest = this.scene.bodies.map(({ kind }, body) => {
      const state = this.states[body] ?? 0;
      if (state & 4) poses.fill(NaN, POSE * body, POSE * (body + 1));
      if (kind !== 'dynamic') return kind === 'fixed' ? Rest.Fixed : Rest.Kinematic;
      return state & 1 ? Rest.Asleep : state & 2 ? Rest.Frozen : Rest.Awake;
    });
    const heights = Array.from(this.states, (state) => (state >>> 8 === 0xffffff ? -1 : state >>> 8));
    return { poses, rest, heights, islands: this.islands, speeds: new Float32Array(rest.length) };
  }

  /** ARROW numbers for each contact of a frame: the push on the lighter body. */
  arrows(frame: number): Float32Array {
    const { at, records, contacts } = this.chunk(frame);
    const { view } = this;
    const out = new Float32Array(8 * contacts);
    for (let i = 0; i < contacts; i++) {
      const from = at + FRAME_HEAD + RECORD * records + CONTACT * i;
      const f32 = (offset: number): number => view.getFloat32(from + offset, true);
      const mass = (offset: number): number => this.scene.bodies[view.getUint32(from + offset, true)]?.mass ?? Infinity;
      const [a, b] = [mass(0), mass(4)];
      // The normal pushes A; what does not move has no mass in the recording.
      const sign = a < b ? 1 : -1;
      const push = f32(40) / Math.min(a, b);
      out.set([f32(12), f32(16), f32(20), sign * f32(24), sign * f32(28), sign * f32(32), push, view.getUint32(from + 8, true) & 1], 8 * i);
    }
    return out;
  }
}

function checkHead(bytes: Uint8Array): void {
  if (bytes.length < 8 || MARK.some((byte, i) => bytes[i] !== byte)) {
    throw new RecordingError('is not a recording: it does not begin with the mark of one; `ishigaki run SCENE --record out.ishi` makes one');
  }
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < HEAD || view.getUint32(12, true) !== crc32(bytes, 0, 12)) {
    throw new RecordingError('is damaged: the checksum of its head does not fit');
  }
  const version = view.getUint32(8, true);
  if (version !== VERSION) {
    throw new RecordingError(`is of version ${version}; this page plays version ${VERSION}: record it again, or use a page of its time`);
  }
}

function walk(bytes: Uint8Array, view: DataView): { scene: Scene; chunks: FrameChunk[]; cut: string | null } {
  let scene: Scene | null = null;
  const chunks: FrameChunk[] = [];
  let cut: string | null = null;
  let at = HEAD;
  for (;;) {
    const place = chunks.length === 0 ? 'before its first frame' : `after frame ${chunks.length - 1}`;
    if (at + AROUND > bytes.length) {
      cut = `is cut off ${place}`;
      break;
    }
    const tag = String.fromCharCode(...bytes.subarray(at, at + 4));
    const length = view.getUint32(at + 4, true);
    const content = at + 8;
    if (length % 4 !== 0 || content + length + 4 > bytes.length) {
      cut = `is cut off or damaged ${place}`;
      break;
    }
    if (view.getUint32(content + length, true) !== crc32(bytes, at, content + length)) {
      cut = `is damaged ${place}: a checksum does not fit`;
      break;
    }
    at = content + length + 4;
    if (tag === 'SCEN' && !scene) scene = readScene(bytes.subarray(content, content + length));
    else if (tag === 'FRAM' && scene) chunks.push(readFrame(view, content, length, chunks.length, scene.bodies.length));
    else if (tag === 'ENDS') break;
    else if (tag !== 'INDX') throw new RecordingError(`has a part ${JSON.stringify(tag)} that does not belong there`);
  }
  if (!scene) throw new RecordingError(cut ?? 'holds no scene');
  if (chunks.length === 0) throw new RecordingError(cut ?? 'holds no frame');
  return { scene, chunks, cut };
}

function readScene(bytes: Uint8Array): Scene {
  try {
    return JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(bytes)) as Scene;
  } catch {
    throw new RecordingError('is damaged: its scene is not JSON');
  }
}

function readFrame(view: DataView, at: number, length: number, number: number, bodies: number): FrameChunk {
  const refuse = (): never => {
    throw new RecordingError(`is damaged: frame ${number} contradicts itself`);
  };
  if (length < FRAME_HEAD) refuse();
  const [records, contacts] = [view.getUint32(at + 56, true), view.getUint32(at + 60, true)];
  const key = view.getUint32(at + 4, true) === 1;
  if (length !== FRAME_HEAD + RECORD * records + CONTACT * contacts) refuse();
  if (view.getUint32(at, true) !== number || (number === 0 && !key) || (key && records !== bodies)) refuse();
  for (let i = 0; i < records; i++) if (view.getUint32(at + FRAME_HEAD + 4 * i, true) >= bodies) refuse();
  return { key, at, records, contacts };
}
