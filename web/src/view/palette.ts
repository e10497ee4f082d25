// Colors: stone and plaster, indigo and vermilion, for light and dark.

import { Color } from 'three';
import { Rest, type Body, type Frame } from '../scene';

export type Theme = 'light' | 'dark';

export interface Scenery {
  sky: string;
  ground: string;
  line: string;
  sun: number;
  fill: number;
  skyLight: string;
  groundLight: string;
}

export const SCENERY: Record<Theme, Scenery> = {
  light: {
    sky: '#eeeae2',
    ground: '#e3ddd1',
    line: '#b9b0a0',
    sun: 2.5,
    fill: 1.65,
    skyLight: '#ffffff',
    groundLight: '#cbbfae',
  },
  dark: {
    sky: '#171a1f',
    ground: '#43423f',
    line: '#74726c',
    sun: 2.0,
    fill: 1.45,
    skyLight: '#d9d7d4',
    groundLight: '#8a8178',
  },
};

export type ColorMode = 'stone' | 'rest' | 'height' | 'island' | 'speed';

export const COLOR_MODES: { id: ColorMode; name: string; doc: string }[] = [
  { id: 'stone', name: 'Stone', doc: 'Every body a stone; heavy ones are dark, light ones pale' },
  { id: 'rest', name: 'Rest', doc: 'Awake, asleep, frozen by aggressive sleep' },
  { id: 'height', name: 'Height', doc: 'Hops from the ground over contacts' },
  { id: 'island', name: 'Island', doc: 'Bodies that touch share a color' },
  { id: 'speed', name: 'Speed', doc: 'Blue at rest, red from 5 m/s' },
];

export const REST_COLORS: Record<Rest, string> = {
  [Rest.Fixed]: '#8a8f98',
  [Rest.Kinematic]: '#4c8dd6',
  [Rest.Awake]: '#e0a13c',
  [Rest.Asleep]: '#5b6aa6',
  [Rest.Frozen]: '#58b7c4',
};

export const REST_NAMES: Record<Rest, string> = {
  [Rest.Fixed]: 'fixed',
  [Rest.Kinematic]: 'kinematic',
  [Rest.Awake]: 'awake',
  [Rest.Asleep]: 'asleep',
  [Rest.Frozen]: 'frozen',
};

const STONES = ['#c2b8a6', '#b3a894', '#cfc6b6', '#a89f90', '#bcae9a', '#9f9a92', '#c9bba3'].map((c) => new Color(c));
const HEAVY = ['#4a5568', '#3f4a5c', '#556074'].map((c) => new Color(c));
const PALE = ['#e9e2d4', '#efe9dd', '#e0d8c8'].map((c) => new Color(c));
const FIXED = new Color('#98948c');
const KINEMATIC = new Color('#4c6fa6');
const SHOT = new Color('#c8452c');
const FLOATING = new Color('#8b8b8b');
const REST = Object.fromEntries(Object.entries(REST_COLORS).map(([k, v]) => [k, new Color(v)]));

/** A body's place, mixed: neighbors get different stones, the same in every run. */
export function mix(i: number): number {
  let h = Math.imul(i + 1, 0x9e3779b1);
  h ^= h >>> 15;
  h = Math.imul(h, 0x85ebca6b);
  return (h ^ (h >>> 13)) >>> 0;
}

export class Palette {
  private readonly stones: Color[];
  private readonly bodies: Body[];
  private readonly scratch = new Color();

  constructor(bodies: Body[]) {
    this.bodies = bodies;
    const masses = bodies.flatMap((b) => (b.mass === undefined ? [] : [b.mass])).sort((a, b) => a - b);
    const median = masses[masses.length >> 1] ?? 1;
    this.stones = bodies.map((body, i) => {
      if (body.kind === 'fixed') return FIXED;
      if (body.kind === 'kinematic') return KINEMATIC;
      if (body.name === 'shot') return SHOT;
      const ratio = (body.mass ?? median) / median;
      const from = ratio > 5 ? HEAVY : ratio < 0.2 ? PALE : STONES;
      return from[mix(i) % from.length] ?? FIXED;
    });
  }

  color(mode: ColorMode, body: number, frame: Frame): Color {
    const rest = frame.rest[body] ?? Rest.Awake;
    const stone = this.stones[body] ?? FIXED;
    if (mode === 'stone') return stone;
    if (mode === 'rest') return REST[rest] ?? stone;
    if (this.bodies[body]?.kind !== 'dynamic') return FIXED;
    const out = this.scratch;
    if (mode === 'height') {
      const height = frame.heights[body] ?? -1;
      return height < 0 ? FLOATING : out.setHSL((0.58 + 0.083 * height) % 1, 0.55, 0.58);
    }
    if (mode === 'island') {
      const island = frame.islands[body] ?? -1;
      return island < 0 ? FLOATING : out.setHSL((mix(island) % 997) / 997, 0.5, 0.58);
    }
    const part = Math.min((frame.speeds[body] ?? 0) / 5, 1);
    return out.setHSL(0.6 - 0.6 * Math.sqrt(part), 0.6, 0.55);
  }
}
