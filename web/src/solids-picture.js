// Draws the loaded objects from the surfaces in their own model files, and finds where a ray hits them.

import {
  BufferAttribute,
  BufferGeometry,
  CircleGeometry,
  Color,
  DoubleSide,
  Group,
  Mesh,
  ShaderMaterial,
} from 'three';
import { POSE_STRIDE } from './event-layout.js';
import { lookOf } from './looks.js';
import { STUDIO_LIGHT } from './studio-light.js';

const VERTEX = /* glsl */ `
  varying vec3 vNormal;
  varying vec3 vAt;
  void main() {
    vec4 at = modelMatrix * vec4(position, 1.0);
    vAt = at.xyz;
    vNormal = mat3(modelMatrix) * normal;
    gl_Position = projectionMatrix * viewMatrix * at;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 tint;
  uniform vec3 accent;
  uniform float surface;
  uniform float glow;
  varying vec3 vNormal;
  varying vec3 vAt;
  ${STUDIO_LIGHT}
  void main() {
    vec3 n = normalize(vNormal);
    vec3 v = normalize(cameraPosition - vAt);
    if (dot(n, v) < 0.0) n = -n;
    float edge = pow(1.0 - max(0.0, dot(n, v)), 4.0);
    vec3 mirrored = studio(reflect(-v, n));
    vec3 light;
    float cover = 1.0;
    if (surface > 1.5) {
      light = tint * 0.5 * soft_light(n) + (0.08 + 0.9 * edge) * mirrored;
      cover = 0.30 + 0.6 * edge;
    } else if (surface > 0.5) {
      light = mix(tint, vec3(1.0), edge) * (mirrored + 0.12 * soft_light(n));
    } else {
      light = tint * soft_light(n) + (0.04 + 0.5 * edge) * mirrored;
    }
    light += accent * glow * (0.08 + 0.5 * edge);
    gl_FragColor = vec4(tone(light), cover);
    #include <colorspace_fragment>
  }
`;

/** A soft shadow on the ground below an object that stands. */
const SHADOW = new ShaderMaterial({
  vertexShader: /* glsl */ `
    varying vec2 vAt;
    void main() {
      vAt = position.xy;
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    }
  `,
  fragmentShader: /* glsl */ `
    varying vec2 vAt;
    void main() {
      float r = dot(vAt, vAt);
      gl_FragColor = vec4(0.0, 0.0, 0.0, 0.6 * (1.0 - r) * (1.0 - r));
    }
  `,
  transparent: true,
  depthWrite: false,
});

export class SolidsPicture {
  /** @param {Color} accent */
  constructor(accent) {
    this.group = new Group();
    this.shadows = new Group();
    this.accent = accent;
  }

  /** @param {import('./strike.js').PlacedSolid[]} objects */
  setObjects(objects) {
    for (const old of this.group.children) /** @type {Mesh} */ (old).geometry.dispose();
    this.group.clear();
    this.shadows.clear();
    for (const object of objects) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(object.solid.vertices, 3));
      geometry.setIndex(new BufferAttribute(object.solid.triangles, 1));
      geometry.computeVertexNormals();
      const look = lookOf(object.solid.material, 0);
      const clear = look.surface > 1.5;
      const material = new ShaderMaterial({
        vertexShader: VERTEX,
        fragmentShader: FRAGMENT,
        uniforms: {
          tint: { value: look.colour },
          accent: { value: this.accent },
          surface: { value: look.surface },
          glow: { value: 0 },
        },
        side: DoubleSide,
        transparent: clear,
        depthWrite: !clear,
      });
      const mesh = new Mesh(geometry, material);
      mesh.position.fromArray(object.position);
      mesh.userData.object = object;
      this.group.add(mesh);
      // Moving objects have no shadow.
      if (!Number.isFinite(object.solid.lowest)) continue;
      const shadow = new Mesh(new CircleGeometry(1, 40), SHADOW);
      shadow.rotation.x = -Math.PI / 2;
      shadow.scale.setScalar(1.15 * widthOf(object.solid.vertices));
      const [x, y, z] = object.position;
      shadow.position.set(x, y + object.solid.lowest + 4e-4, z);
      this.shadows.add(shadow);
    }
  }

  /**
   * @param {Map<number, number>} glow by key, 0 to 1
   * @param {Float32Array} poses of all bodies
   * @param {number} time [s]
   */
  update(glow, poses, time) {
    for (const mesh of this.group.children) {
      const { body, birth, death } = mesh.userData.object;
      if (body !== undefined) {
        mesh.visible = time >= birth && time < death;
        mesh.position.fromArray(poses, body * POSE_STRIDE);
        mesh.quaternion.fromArray(poses, body * POSE_STRIDE + 3);
      }
      const material = /** @type {ShaderMaterial} */ (/** @type {Mesh} */ (mesh).material);
      material.uniforms.glow.value = glow.get(mesh.userData.object.key) ?? 0;
    }
  }

  /**
   * @param {import('three').Raycaster} ray
   * @returns {{ object: import('./strike.js').PlacedSolid, point: number[] } | null}
   */
  hit(ray) {
    const [first] = ray.intersectObjects(this.group.children, false);
    if (!first) return null;
    return { object: first.object.userData.object, point: first.point.toArray() };
  }
}

/** Largest distance from the vertical through the centre of mass [m]. @param {Float32Array} vertices */
function widthOf(vertices) {
  let widest = 0;
  for (let at = 0; at < vertices.length; at += 3) {
    widest = Math.max(widest, Math.hypot(vertices[at], vertices[at + 2]));
  }
  return widest;
}
