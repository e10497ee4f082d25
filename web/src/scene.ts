// What both pages draw: the SCEN chunk of docs/recording-format.md, which the live engine writes too.

export type Vec3 = [number, number, number];
export type Quat = [number, number, number, number];

export type Geometry =
  | { ball: { radius: number } }
  | { cuboid: { half_extents: Vec3 } }
  | { capsule: { half_length: number; radius: number } }
  | { cylinder: { half_height: number; radius: number } }
  | { cone: { half_height: number; radius: number } }
  | { half_space: { normal: Vec3 } }
  | { convex_hull: { vertices: number[]; faces: number[][] } }
  | { triangle_mesh: { vertices: number[]; triangles: number[] } }
  | { height_field: { rows: number; columns: number; size_x: number; size_z: number; heights: number[] } };

export interface Shape {
  geometry: number;
  position: Vec3;
  rotation: Quat;
  sensor: boolean;
}

export interface Body {
  name: string;
  kind: 'fixed' | 'kinematic' | 'dynamic';
  mass?: number;
  shapes: Shape[];
}

export interface Placement {
  position: Vec3;
  rotation: Quat;
}

export interface Joint {
  kind: 'ball' | 'hinge' | 'slider' | 'fixed' | 'distance' | 'generic';
  body_a: number;
  body_b: number;
  frame_a: Placement;
  frame_b: Placement;
}

export interface SceneModel {
  up: Vec3;
  geometries: Geometry[];
  bodies: Body[];
  joints: Joint[];
}

export interface Camera {
  position: Vec3;
  target: Vec3;
}

/** Numbers of a pose: position, then the quaternion x, y, z, w. */
export const POSE = 7;

export const enum Rest {
  Fixed = 0,
  Kinematic = 1,
  Awake = 2,
  Asleep = 3,
  Frozen = 4,
}

/** The bodies at one moment; arrays by place in the list of bodies. */
export interface Frame {
  /** POSE numbers for each body; not finite: not drawn. */
  poses: Float32Array;
  rest: ArrayLike<number>;
  /** Hops from the ground, −1 without a way down. */
  heights: ArrayLike<number>;
  /** −1 without one. */
  islands: ArrayLike<number>;
  /** m/s. */
  speeds: ArrayLike<number>;
}

/** Numbers of a contact arrow: position, direction of the push, λ/m in m/s, frozen. */
export const ARROW = 8;
