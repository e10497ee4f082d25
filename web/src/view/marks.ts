// What is drawn over the bodies: contact arrows and lines.

import {
  Color,
  ConeGeometry,
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
  type BufferGeometry,
} from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { ARROW } from '../scene';

const UP = new Vector3(0, 1, 0);
const WEAK = new Color('#f0b429');
const STRONG = new Color('#e12d39');
const FROZEN = new Color('#3aa6c4');
/** Arrows are not longer than this many typical bodies. */
const LONGEST = 6;

/** A point for each contact, an arrow along the push, as long as its impulse. */
export class Arrows {
  readonly group = new Group();
  private points?: InstancedMesh;
  private shafts?: InstancedMesh;
  private heads?: InstancedMesh;
  private capacity = 0;

  /** `size`: a typical body, m. `unit`: λ/m of an arrow as long as that, m/s. */
  update(arrows: Float32Array, size: number, unit: number): void {
    const count = Math.floor(arrows.length / ARROW);
    this.reserve(count);
    const { points, shafts, heads } = this;
    if (!points || !shafts || !heads) return;
    points.count = shafts.count = heads.count = count;
    const [matrix, position, direction, scale] = [new Matrix4(), new Vector3(), new Vector3(), new Vector3()];
    const rotation = new Quaternion();
    const color = new Color();
    const thick = 0.022 * size;
    for (let i = 0; i < count; i++) {
      const at = i * ARROW;
      position.fromArray(arrows, at);
      rotation.setFromUnitVectors(UP, direction.fromArray(arrows, at + 3));
      const strength = (arrows[at + 6] ?? 0) / unit;
      const length = size * Math.min(strength, LONGEST);
      if (arrows[at + 7]) color.copy(FROZEN);
      else color.lerpColors(WEAK, STRONG, Math.min(strength / 3, 1));
      points.setMatrixAt(i, matrix.compose(position, rotation, scale.setScalar(2.2 * thick)));
      const head = Math.min(0.16 * size, 0.6 * length);
      shafts.setMatrixAt(i, matrix.compose(position, rotation, scale.set(thick, Math.max(length - head, 1e-6), thick)));
      position.addScaledVector(direction, length - head);
      heads.setMatrixAt(i, matrix.compose(position, rotation, scale.set(0.45 * head, head, 0.45 * head)));
      for (const mesh of [points, shafts, heads]) mesh.setColorAt(i, color);
    }
    for (const mesh of [points, shafts, heads]) {
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  private reserve(count: number): void {
    if (count <= this.capacity) return;
    this.dispose();
    this.capacity = Math.max(64, 2 * count);
    const make = (geometry: BufferGeometry): InstancedMesh => {
      const mesh = new InstancedMesh(geometry, new MeshBasicMaterial({ depthTest: false, transparent: true }), this.capacity);
      mesh.frustumCulled = false;
      mesh.renderOrder = 10;
      this.group.add(mesh);
      return mesh;
    };
    this.points = make(new SphereGeometry(1, 10, 8));
    this.shafts = make(new CylinderGeometry(1, 1, 1, 6).translate(0, 0.5, 0));
    this.heads = make(new ConeGeometry(1, 1, 10).translate(0, 0.5, 0));
  }

  dispose(): void {
    for (const mesh of [this.points, this.shafts, this.heads]) {
      mesh?.geometry.dispose();
      (mesh?.material as MeshBasicMaterial | undefined)?.dispose();
      mesh?.dispose();
    }
    this.group.clear();
    this.capacity = 0;
  }
}

/** Numbers of a segment as the engine writes them: two ends of position and color. */
const SEGMENT = 14;

/** Line segments with colors, some pixels wide, over everything. */
export class Lines {
  readonly group = new Group();
  private readonly material = new LineMaterial({ vertexColors: true, linewidth: 2, depthTest: false, transparent: true });
  private mesh?: LineSegments2;

  update(segments: Float32Array): void {
    const count = Math.floor(segments.length / SEGMENT);
    this.clear();
    if (count === 0) return;
    const positions = new Float32Array(6 * count);
    const colors = new Float32Array(6 * count);
    for (let i = 0; i < 2 * count; i++) {
      const at = (i * SEGMENT) / 2;
      positions.set(segments.subarray(at, at + 3), 3 * i);
      colors.set(segments.subarray(at + 3, at + 6), 3 * i);
    }
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(positions);
    geometry.setColors(colors);
    this.mesh = new LineSegments2(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 9;
    this.group.add(this.mesh);
  }

  private clear(): void {
    this.mesh?.geometry.dispose();
    this.group.clear();
    delete this.mesh;
  }

  dispose(): void {
    this.clear();
    this.material.dispose();
  }
}
