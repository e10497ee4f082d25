// The mesh of each geometry. Equal forms share one mesh; what differs by size alone is scaled.

import { BufferAttribute, BufferGeometry, CapsuleGeometry, ConeGeometry, CylinderGeometry, SphereGeometry } from 'three';
import { mergeVertices, toCreasedNormals } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Geometry, Vec3 } from '../scene';

/** A mesh to draw instances of, and the size of one instance. */
export interface Form {
  /** Equal keys: the same mesh. */
  key: string;
  scale: Vec3;
  make: () => BufferGeometry;
}

/** More boxes of different sizes than this are scaled copies of one box without a bevel. */
const BEVELED_SIZES = 48;

/** `shapes`: how many there are in all; round ones get fewer triangles in a crowd, where each is small. */
export function forms(geometries: Geometry[], shapes: number): (Form | null)[] {
  const sizes = new Set(geometries.flatMap((g) => ('cuboid' in g ? [g.cuboid.half_extents.join()] : [])));
  const round = shapes > 1500 ? 14 : 28;
  return geometries.map((geometry, place) => form(geometry, place, sizes.size <= BEVELED_SIZES, round));
}

/** `null` for half-spaces, which are drawn as ground. */
function form(geometry: Geometry, place: number, beveled: boolean, round: number): Form | null {
  const same = (s: number): Vec3 => [s, s, s];
  if ('ball' in geometry) {
    return { key: 'ball', scale: same(geometry.ball.radius), make: () => new SphereGeometry(1, round, Math.round(0.65 * round)) };
  }
  if ('cuboid' in geometry) {
    const half = geometry.cuboid.half_extents;
    if (!beveled) return { key: 'box', scale: half, make: () => bevelBox([1, 1, 1], 0.06) };
    return { key: `box ${half.join()}`, scale: same(1), make: () => bevelBox(half, 0.1 * Math.min(...half)) };
  }
  if ('capsule' in geometry) {
    const { half_length, radius } = geometry.capsule;
    const ratio = Number((half_length / radius).toPrecision(4));
    return { key: `capsule ${ratio}`, scale: same(radius), make: () => new CapsuleGeometry(1, 2 * ratio, Math.round(round / 4), round) };
  }
  if ('cylinder' in geometry) {
    const { half_height, radius } = geometry.cylinder;
    return { key: 'cylinder', scale: [radius, half_height, radius], make: () => new CylinderGeometry(1, 1, 2, round) };
  }
  if ('cone' in geometry) {
    const { half_height, radius } = geometry.cone;
    return { key: 'cone', scale: [radius, half_height, radius], make: () => new ConeGeometry(1, 2, round) };
  }
  if ('half_space' in geometry) return null;
  return { key: `mesh ${place}`, scale: same(1), make: () => triangles(geometry) };
}

function triangles(geometry: Geometry): BufferGeometry {
  if ('convex_hull' in geometry) {
    const { vertices, faces } = geometry.convex_hull;
    const fans = faces.flatMap((f) => f.slice(2).flatMap((corner, i) => [f[0] ?? 0, f[i + 1] ?? 0, corner]));
    return mesh(vertices, fans, 0.3);
  }
  if ('triangle_mesh' in geometry) return mesh(geometry.triangle_mesh.vertices, geometry.triangle_mesh.triangles, 0.6);
  if ('height_field' in geometry) {
    const { rows, columns, size_x, size_z, heights } = geometry.height_field;
    const vertices = heights.flatMap((h, i) => [
      ((i % columns) / (columns - 1) - 0.5) * size_x,
      h,
      (Math.floor(i / columns) / (rows - 1) - 0.5) * size_z,
    ]);
    const indices: number[] = [];
    for (let row = 0; row + 1 < rows; row++) {
      for (let i = row * columns; i + 1 < (row + 1) * columns; i++) {
        indices.push(i, i + columns, i + 1, i + columns, i + columns + 1, i + 1);
      }
    }
    return mesh(vertices, indices, 1);
  }
  return new BufferGeometry();
}

/** Edges sharper than `crease` (rad) stay sharp. */
function mesh(vertices: number[], indices: number[], crease: number): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute('position', new BufferAttribute(new Float32Array(vertices), 3));
  made.setIndex(indices);
  return toCreasedNormals(mergeVertices(made), crease);
}

/** A box with cut edges: 24 corners, each with its face's normal, so that light runs around the edges. */
export function bevelBox(half: Vec3, cut: number): BufferGeometry {
  const positions: number[] = [];
  const normals: number[] = [];
  const indices: number[] = [];
  // The corner of octant `s` on the face along `axis`.
  const place = new Map<string, number>();
  const signs: Vec3[] = [];
  for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) signs.push([x, y, z]);
  for (const s of signs) {
    for (let axis = 0; axis < 3; axis++) {
      place.set(`${s.join()} ${axis}`, positions.length / 3);
      for (let i = 0; i < 3; i++) {
        const sign = s[i] ?? 1;
        positions.push(sign * ((half[i] ?? 1) - (i === axis ? 0 : cut)));
        normals.push(i === axis ? sign : 0);
      }
    }
  }
  const at = (s: Vec3, axis: number): number => place.get(`${s.join()} ${axis}`) ?? 0;
  const point = (i: number): Vec3 => [positions[3 * i] ?? 0, positions[3 * i + 1] ?? 0, positions[3 * i + 2] ?? 0];
  // Turned so that it looks outward: the box is about the origin.
  const triangle = (a: number, b: number, c: number): void => {
    const [p, q, r] = [point(a), point(b), point(c)];
    const u: Vec3 = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
    const v: Vec3 = [r[0] - p[0], r[1] - p[1], r[2] - p[2]];
    const out =
      (u[1] * v[2] - u[2] * v[1]) * (p[0] + q[0] + r[0]) +
      (u[2] * v[0] - u[0] * v[2]) * (p[1] + q[1] + r[1]) +
      (u[0] * v[1] - u[1] * v[0]) * (p[2] + q[2] + r[2]);
    indices.push(a, ...(out > 0 ? [b, c] : [c, b]));
  };
  const quad = (a: number, b: number, c: number, d: number): void => {
    triangle(a, b, c);
    triangle(b, c, d);
  };
  const flip = (s: Vec3, axis: number): Vec3 => s.map((x, i) => (i === axis ? -x : x)) as Vec3;
  for (const s of signs) {
    triangle(at(s, 0), at(s, 1), at(s, 2));
    for (let axis = 0; axis < 3; axis++) {
      const [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
      // An edge along `axis`, from both its ends' point of view: once.
      if ((s[axis] ?? 1) > 0) {
        const t = flip(s, axis);
        quad(at(s, i), at(s, j), at(t, i), at(t, j));
      }
      // The face along `axis`: from one of its corners.
      if ((s[i] ?? 1) > 0 && (s[j] ?? 1) > 0) {
        quad(at(s, axis), at(flip(s, i), axis), at(flip(s, j), axis), at(flip(flip(s, i), j), axis));
      }
    }
  }
  const box = new BufferGeometry();
  box.setAttribute('position', new BufferAttribute(new Float32Array(positions), 3));
  box.setAttribute('normal', new BufferAttribute(new Float32Array(normals), 3));
  box.setIndex(indices);
  return box;
}
