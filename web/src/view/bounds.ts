// Where the bodies are: for the camera, the light and the shadows.

import { Box3, Quaternion, Vector3 } from 'three';
import { POSE, type Frame, type Geometry, type SceneModel } from '../scene';

/** Around the dynamic bodies; around all whose shapes are bounded, if there are none. */
export function boundingBox(model: SceneModel, frame: Frame): Box3 {
  const [all, dynamic] = [new Box3(), new Box3()];
  model.bodies.forEach((body, place) => {
    const center = new Vector3().fromArray(frame.poses, place * POSE);
    if (!Number.isFinite(center.x + center.y + center.z)) return;
    const turn = new Quaternion().fromArray(frame.poses, place * POSE + 3);
    for (const shape of body.shapes) {
      const geometry = model.geometries[shape.geometry];
      const radius = geometry && reach(geometry);
      if (radius === undefined) continue;
      const size = new Vector3().setScalar(2 * radius);
      center.fromArray(frame.poses, place * POSE).add(new Vector3(...shape.position).applyQuaternion(turn));
      const box = new Box3().setFromCenterAndSize(center, size);
      all.union(box);
      if (body.kind === 'dynamic') dynamic.union(box);
    }
  });
  const box = dynamic.isEmpty() ? all : dynamic;
  return box.isEmpty() ? box.setFromCenterAndSize(new Vector3(), new Vector3().setScalar(6)) : box;
}

/** Farthest point from the origin, m; nothing for what has no bounds. */
function reach(geometry: Geometry): number | undefined {
  if ('ball' in geometry) return geometry.ball.radius;
  if ('cuboid' in geometry) return Math.hypot(...geometry.cuboid.half_extents);
  if ('capsule' in geometry) return geometry.capsule.half_length + geometry.capsule.radius;
  if ('cylinder' in geometry) return Math.hypot(geometry.cylinder.half_height, geometry.cylinder.radius);
  if ('cone' in geometry) return Math.hypot(geometry.cone.half_height, geometry.cone.radius);
  if ('half_space' in geometry) return undefined;
  if ('height_field' in geometry) return Math.hypot(geometry.height_field.size_x, geometry.height_field.size_z) / 2;
  const vertices = 'convex_hull' in geometry ? geometry.convex_hull.vertices : geometry.triangle_mesh.vertices;
  let square = 0;
  for (let i = 0; i + 2 < vertices.length; i += 3) {
    square = Math.max(square, (vertices[i] ?? 0) ** 2 + (vertices[i + 1] ?? 0) ** 2 + (vertices[i + 2] ?? 0) ** 2);
  }
  return Math.sqrt(square);
}
