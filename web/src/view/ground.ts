// Half-spaces: a plane with a grid of one typical body that fades into the sky.

import { Group, Mesh, MeshStandardMaterial, PlaneGeometry, Quaternion, Vector3, Color } from 'three';
import { POSE, type Frame, type SceneModel } from '../scene';
import type { Scenery } from './palette';

interface Plane {
  body: number;
  position: Vector3;
  rotation: Quaternion;
  mesh: Mesh;
}

export class Ground {
  readonly group = new Group();
  private readonly planes: Plane[] = [];
  private readonly line = { value: new Color() };
  private readonly material = new MeshStandardMaterial({ roughness: 1, metalness: 0 });

  /** `reach`: how far the plane is drawn, m; `cell`: of the grid, m. */
  constructor(model: SceneModel, reach: number, cell: number) {
    this.material.onBeforeCompile = (shader) => {
      shader.uniforms.gridLine = this.line;
      shader.uniforms.gridCell = { value: cell };
      shader.uniforms.gridReach = { value: reach };
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nvarying vec2 vGrid;')
        .replace('#include <begin_vertex>', '#include <begin_vertex>\nvGrid = position.xy;');
      shader.fragmentShader = shader.fragmentShader
        .replace(
          '#include <common>',
          `#include <common>
          varying vec2 vGrid;
          uniform vec3 gridLine;
          uniform float gridCell, gridReach;
          float gridAt(float cell, float width) {
            vec2 p = vGrid / cell, d = fwidth(p);
            vec2 a = abs(fract(p - 0.5) - 0.5) / max(d, vec2(1e-6));
            float line = 1.0 - min(min(a.x, a.y) / width, 1.0);
            return line * (1.0 - smoothstep(0.15, 0.6, max(d.x, d.y)));
          }`,
        )
        .replace(
          '#include <color_fragment>',
          `#include <color_fragment>
          float grid = max(0.4 * gridAt(gridCell, 1.1), 0.85 * gridAt(10.0 * gridCell, 1.4));
          diffuseColor.rgb = mix(diffuseColor.rgb, gridLine, grid * (1.0 - smoothstep(0.05, 0.5, length(vGrid) / gridReach)));`,
        );
    };
    model.bodies.forEach((body, place) => {
      for (const shape of body.shapes) {
        const geometry = model.geometries[shape.geometry];
        if (!geometry || !('half_space' in geometry)) continue;
        const rotation = new Quaternion().setFromUnitVectors(
          new Vector3(0, 0, 1),
          new Vector3(...geometry.half_space.normal),
        );
        rotation.premultiply(new Quaternion(...shape.rotation));
        const mesh = new Mesh(new PlaneGeometry(2 * reach, 2 * reach), this.material);
        mesh.receiveShadow = true;
        this.planes.push({ body: place, position: new Vector3(...shape.position), rotation, mesh });
        this.group.add(mesh);
      }
    });
  }

  theme(scenery: Scenery): void {
    this.material.color.set(scenery.ground);
    this.line.value.set(scenery.line);
  }

  update(frame: Frame): void {
    const turn = new Quaternion();
    for (const { body, position, rotation, mesh } of this.planes) {
      turn.fromArray(frame.poses, body * POSE + 3);
      mesh.position.copy(position).applyQuaternion(turn);
      mesh.position.x += frame.poses[body * POSE] ?? 0;
      mesh.position.y += frame.poses[body * POSE + 1] ?? 0;
      mesh.position.z += frame.poses[body * POSE + 2] ?? 0;
      mesh.quaternion.multiplyQuaternions(turn, rotation);
    }
  }

  dispose(): void {
    this.planes.forEach(({ mesh }) => mesh.geometry.dispose());
    this.material.dispose();
  }
}
