// All bodies of a scene as instanced meshes: one draw call for each form, whatever the number of bodies.

import {
  DynamicDrawUsage,
  Group,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
  Quaternion,
  Vector3,
  type BufferGeometry,
  type WebGLProgramParametersWithUniforms,
} from 'three';
import { POSE, type Frame, type SceneModel } from '../scene';
import { forms } from './forms';
import { Palette, type ColorMode } from './palette';

interface Placed {
  body: number;
  local: Matrix4;
}

interface Batch {
  mesh: InstancedMesh;
  shapes: Placed[];
}

const NOWHERE = new Matrix4().makeScale(0, 0, 0);

export class Bodies {
  readonly group = new Group();
  private readonly batches: Batch[] = [];
  private readonly palette: Palette;
  private readonly pose = new Matrix4();
  private readonly matrix = new Matrix4();
  private readonly position = new Vector3();
  private readonly rotation = new Quaternion();
  private readonly one = new Vector3(1, 1, 1);

  constructor(model: SceneModel, grain: boolean) {
    this.palette = new Palette(model.bodies);
    const count = model.bodies.reduce((sum, body) => sum + body.shapes.length, 0);
    const made = forms(model.geometries, count);
    const groups = new Map<string, { make: () => BufferGeometry; sensor: boolean; shapes: Placed[] }>();
    model.bodies.forEach((body, place) => {
      for (const shape of body.shapes) {
        const form = made[shape.geometry];
        if (!form) continue;
        const key = `${form.key} ${shape.sensor}`;
        const local = new Matrix4().compose(
          new Vector3(...shape.position),
          new Quaternion(...shape.rotation),
          new Vector3(...form.scale),
        );
        const group = groups.get(key) ?? { make: form.make, sensor: shape.sensor, shapes: [] };
        group.shapes.push({ body: place, local });
        groups.set(key, group);
      }
    });
    for (const { make, sensor, shapes } of groups.values()) {
      const mesh = new InstancedMesh(make(), sensor ? sensorMaterial() : stoneMaterial(grain), shapes.length);
      mesh.instanceMatrix.setUsage(DynamicDrawUsage);
      // Bodies move out of the bounds of the start.
      mesh.frustumCulled = false;
      mesh.castShadow = !sensor;
      mesh.receiveShadow = !sensor;
      this.batches.push({ mesh, shapes });
      this.group.add(mesh);
    }
  }

  update(frame: Frame, mode: ColorMode): void {
    const { poses } = frame;
    for (const { mesh, shapes } of this.batches) {
      shapes.forEach(({ body, local }, i) => {
        const at = body * POSE;
        this.position.fromArray(poses, at);
        this.rotation.fromArray(poses, at + 3);
        if (Number.isFinite(this.position.x + this.position.y + this.position.z + this.rotation.w)) {
          this.pose.compose(this.position, this.rotation, this.one);
          mesh.setMatrixAt(i, this.matrix.multiplyMatrices(this.pose, local));
        } else {
          mesh.setMatrixAt(i, NOWHERE);
        }
        mesh.setColorAt(i, this.palette.color(mode, body, frame));
      });
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  /** Shows what is inside. */
  setOpacity(opacity: number): void {
    for (const { mesh } of this.batches) {
      const material = mesh.material as MeshStandardMaterial;
      if (material.userData.sensor) continue;
      material.transparent = opacity < 1;
      material.opacity = opacity;
      material.depthWrite = opacity === 1;
    }
  }

  dispose(): void {
    for (const { mesh } of this.batches) {
      mesh.geometry.dispose();
      (mesh.material as MeshStandardMaterial).dispose();
      mesh.dispose();
    }
  }
}

function sensorMaterial(): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ transparent: true, opacity: 0.25, depthWrite: false });
  material.userData.sensor = true;
  return material;
}

/** Matte; with `grain`, mottled like stone in the frame of each body. */
function stoneMaterial(grain: boolean): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ roughness: 0.86, metalness: 0 });
  if (grain) material.onBeforeCompile = addGrain;
  return material;
}

function addGrain(shader: WebGLProgramParametersWithUniforms): void {
  shader.vertexShader = shader.vertexShader
    .replace('#include <common>', '#include <common>\nvarying vec3 vGrain;')
    .replace(
      '#include <begin_vertex>',
      `#include <begin_vertex>
      vec3 grainScale = vec3(length(instanceMatrix[0].xyz), length(instanceMatrix[1].xyz), length(instanceMatrix[2].xyz));
      vGrain = position * grainScale * 9.0 + vec3(float(gl_InstanceID % 97) * 7.3, float(gl_InstanceID % 89) * 3.1, 0.0);`,
    );
  shader.fragmentShader = shader.fragmentShader
    .replace(
      '#include <common>',
      `#include <common>
      varying vec3 vGrain;
      float grainHash(vec3 p) {
        p = fract(p * 0.3183099 + 0.1);
        p *= 17.0;
        return fract(p.x * p.y * p.z * (p.x + p.y + p.z));
      }
      float grainNoise(vec3 x) {
        vec3 i = floor(x), f = fract(x);
        f = f * f * (3.0 - 2.0 * f);
        return mix(
          mix(mix(grainHash(i), grainHash(i + vec3(1, 0, 0)), f.x), mix(grainHash(i + vec3(0, 1, 0)), grainHash(i + vec3(1, 1, 0)), f.x), f.y),
          mix(mix(grainHash(i + vec3(0, 0, 1)), grainHash(i + vec3(1, 0, 1)), f.x), mix(grainHash(i + vec3(0, 1, 1)), grainHash(i + vec3(1, 1, 1)), f.x), f.y),
          f.z);
      }`,
    )
    .replace(
      '#include <color_fragment>',
      `#include <color_fragment>
      float grain = 0.6 * grainNoise(vGrain * 0.45) + 0.4 * grainNoise(vGrain * 2.1);
      diffuseColor.rgb *= 0.84 + 0.3 * grain;`,
    );
}
