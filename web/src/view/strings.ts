// Distance joints as strings: without them a pendulum would hang from nothing.

import { BufferAttribute, BufferGeometry, DynamicDrawUsage, LineBasicMaterial, LineSegments, Quaternion, Vector3 } from 'three';
import { POSE, type Frame, type Joint, type Placement, type SceneModel } from '../scene';

export class Strings {
  readonly mesh: LineSegments;
  private readonly joints: Joint[];
  private readonly ends: BufferAttribute;

  constructor(model: SceneModel) {
    this.joints = model.joints.filter(({ kind }) => kind === 'distance');
    this.ends = new BufferAttribute(new Float32Array(6 * this.joints.length), 3).setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry().setAttribute('position', this.ends);
    this.mesh = new LineSegments(geometry, new LineBasicMaterial({ color: '#7d7468' }));
    this.mesh.frustumCulled = false;
  }

  update({ poses }: Frame): void {
    const [point, turn] = [new Vector3(), new Quaternion()];
    const place = (end: number, body: number, { position }: Placement): void => {
      point.set(...position).applyQuaternion(turn.fromArray(poses, POSE * body + 3));
      const at = POSE * body;
      this.ends.setXYZ(end, point.x + (poses[at] ?? 0), point.y + (poses[at + 1] ?? 0), point.z + (poses[at + 2] ?? 0));
    };
    this.joints.forEach((joint, i) => {
      place(2 * i, joint.body_a, joint.frame_a);
      place(2 * i + 1, joint.body_b, joint.frame_b);
    });
    this.ends.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    (this.mesh.material as LineBasicMaterial).dispose();
  }
}
