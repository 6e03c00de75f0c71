// Draws all balls in one draw call and their soft shadows in another. Attributes per ball: position, radius,
// orientation.

import {
  DynamicDrawUsage,
  Group,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Mesh,
  PlaneGeometry,
  ShaderMaterial,
} from 'three';
import { POSE_STRIDE } from './event-layout.js';
import { lookOf } from './looks.js';
import { STUDIO_LIGHT } from './studio-light.js';

// A ball is a square that faces the camera, on which the fragment shader draws a sphere: exact at any size,
// with two triangles. The square is at the foremost point of the ball, so that the ground does not cut it.
const BALL_VERTEX = /* glsl */ `
  attribute vec4 place;
  attribute vec4 turn;
  attribute vec3 tint;
  attribute vec3 look;
  varying vec2 vAt;
  varying vec3 vRight;
  varying vec3 vUp;
  varying vec3 vToEye;
  varying vec4 vPlace;
  varying vec4 vTurn;
  varying vec3 vTint;
  varying vec3 vLook;
  void main() {
    vec3 way = cameraPosition - place.xyz;
    float distance = length(way);
    vToEye = way / distance;
    vRight = normalize(cross(vec3(0.0, 1.0, 0.0), vToEye));
    vUp = cross(vToEye, vRight);
    vAt = position.xy;
    vPlace = place;
    vTurn = turn;
    vTint = tint;
    vLook = look;
    // In perspective, the outline of a near ball is larger than its radius.
    float outline = place.w * distance / sqrt(max(1e-9, distance * distance - place.w * place.w));
    vec3 at = place.xyz + outline * (position.x * vRight + position.y * vUp);
    vec4 seen = projectionMatrix * viewMatrix * vec4(at, 1.0);
    vec4 front = projectionMatrix * viewMatrix * vec4(place.xyz + place.w * vToEye, 1.0);
    seen.z = front.z / front.w * seen.w;
    gl_Position = seen;
  }
`;

const BALL_FRAGMENT = /* glsl */ `
  uniform float floorHeight;
  uniform vec3 accent;
  varying vec2 vAt;
  varying vec3 vRight;
  varying vec3 vUp;
  varying vec3 vToEye;
  varying vec4 vPlace;
  varying vec4 vTurn;
  varying vec3 vTint;
  varying vec3 vLook;
  ${STUDIO_LIGHT}
  void main() {
    float square = dot(vAt, vAt);
    if (square > 1.0) discard;
    float facing = sqrt(1.0 - square);
    vec3 v = vToEye;
    vec3 n = vAt.x * vRight + vAt.y * vUp + facing * v;
    vec3 mirrored = studio(reflect(-v, n));
    float edge = pow(1.0 - facing, 5.0);
    vec3 colour = vTint;
    // look.z: stripe of a pool ball.
    if (vLook.z > 0.5) {
      // Height on the ball in its own axes.
      float own = n.y + 2.0 * dot(cross(vTurn.xyz, cross(vTurn.xyz, n) - vTurn.w * n), vec3(0.0, 1.0, 0.0));
      colour = mix(vec3(0.86, 0.83, 0.76), colour, step(abs(own), 0.5));
    }
    // Near the floor: less light from below.
    float near = exp(-(vPlace.y / vPlace.w + n.y - floorHeight / vPlace.w) / 0.9);
    float open = 1.0 - 0.65 * near;
    vec3 light;
    if (vLook.x > 1.5) {
      vec3 through = studio(refract(-v, n, 0.66));
      light = colour * (0.45 * soft_light(n) * open + 1.1 * through) + (0.06 + 0.94 * edge) * mirrored;
    } else if (vLook.x > 0.5) {
      light = mix(colour, vec3(1.0), edge) * (mirrored + 0.10 * soft_light(n)) * open;
    } else {
      light = colour * soft_light(n) * open + (0.035 + 0.6 * edge) * mirrored;
    }
    // look.y: glow after an impact.
    light += accent * vLook.y * (0.25 + 0.75 * (1.0 - facing));
    gl_FragColor = vec4(tone(light), 1.0);
    #include <colorspace_fragment>
  }
`;

const SHADOW_VERTEX = /* glsl */ `
  uniform float floorHeight;
  attribute vec4 place;
  varying vec2 vAt;
  varying float vDark;
  void main() {
    float height = max(0.0, place.y - place.w - floorHeight);
    // Above this height the shadow is invisible.
    float near = 1.0 - height / (7.0 * place.w);
    float spread = step(0.0, near) * (place.w * 1.25 + 0.2 * height);
    vAt = position.xy;
    vDark = 0.72 * near * near * step(floorHeight, place.y);
    vec3 at = vec3(place.x + position.x * spread, floorHeight + 0.0004, place.z - position.y * spread);
    gl_Position = projectionMatrix * viewMatrix * vec4(at, 1.0);
  }
`;

const SHADOW_FRAGMENT = /* glsl */ `
  varying vec2 vAt;
  varying float vDark;
  void main() {
    float r = dot(vAt, vAt);
    if (r > 1.0) discard;
    gl_FragColor = vec4(0.0, 0.0, 0.0, vDark * (1.0 - r) * (1.0 - r));
  }
`;

export class BallsPicture {
  /** @param {import('three').Color} accent */
  constructor(accent) {
    this.group = new Group();
    this.uniforms = { floorHeight: { value: -1e6 }, accent: { value: accent } };
    this.ballMaterial = new ShaderMaterial({
      vertexShader: BALL_VERTEX,
      fragmentShader: BALL_FRAGMENT,
      uniforms: this.uniforms,
    });
    this.shadowMaterial = new ShaderMaterial({
      vertexShader: SHADOW_VERTEX,
      fragmentShader: SHADOW_FRAGMENT,
      uniforms: this.uniforms,
      transparent: true,
      depthWrite: false,
    });
    /** Body number of each ball. @type {number[]} */
    this.bodyOf = [];
    this.capacity = 0;
  }

  /**
   * @param {import('./world.js').Body[]} bodies
   * @param {{ name: string }[]} materials
   */
  setBodies(bodies, materials) {
    this.bodyOf = [];
    bodies.forEach((body, index) => {
      if (!body.plane && body.radius > 0) this.bodyOf.push(index);
    });
    const count = this.bodyOf.length;
    if (!this.place || count > this.capacity) this.allocate(count);
    this.bodyOf.forEach((index, ball) => {
      const body = bodies[index];
      const look = lookOf(materials[body.material]?.name ?? '', index);
      this.tint.setXYZ(ball, look.colour.r, look.colour.g, look.colour.b);
      this.look.setXYZ(ball, look.surface, 0, look.stripe);
      this.place.setXYZW(ball, 0, -1e6, 0, body.radius);
    });
    this.tint.needsUpdate = true;
    this.balls.geometry.instanceCount = count;
    this.shadows.geometry.instanceCount = count;
  }

  /** @param {number} count */
  allocate(count) {
    this.capacity = Math.max(64, Math.ceil(count * 1.5));
    const attribute = (/** @type {number} */ size) => {
      const made = new InstancedBufferAttribute(new Float32Array(size * this.capacity), size);
      made.setUsage(DynamicDrawUsage);
      return made;
    };
    this.place = attribute(4);
    this.turn = attribute(4);
    this.tint = attribute(3);
    this.look = attribute(3);
    for (const old of this.group.children) /** @type {Mesh} */ (old).geometry.dispose();
    this.group.clear();
    this.balls = this.mesh(this.ballMaterial);
    this.shadows = this.mesh(this.shadowMaterial);
    this.group.add(this.shadows, this.balls);
  }

  /** A square for each ball. @param {ShaderMaterial} material */
  mesh(material) {
    const form = new PlaneGeometry(2, 2);
    const geometry = new InstancedBufferGeometry();
    geometry.index = form.index;
    geometry.setAttribute('position', form.getAttribute('position'));
    geometry.setAttribute('place', this.place);
    geometry.setAttribute('turn', this.turn);
    geometry.setAttribute('tint', this.tint);
    geometry.setAttribute('look', this.look);
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    return mesh;
  }

  /**
   * @param {Float32Array} poses of all bodies
   * @param {number} known bodies that have a pose
   * @param {Map<number, number>} glow by body, 0 to 1
   */
  update(poses, known, glow) {
    if (!this.place) return;
    const place = this.place.array;
    const turn = this.turn.array;
    const look = this.look.array;
    this.bodyOf.forEach((body, ball) => {
      const at = body * POSE_STRIDE;
      if (body >= known) {
        place[4 * ball + 1] = -1e6;
        return;
      }
      for (let i = 0; i < 3; i += 1) place[4 * ball + i] = poses[at + i];
      for (let i = 0; i < 4; i += 1) turn[4 * ball + i] = poses[at + 3 + i];
      look[3 * ball + 1] = glow.get(body) ?? 0;
    });
    this.place.needsUpdate = true;
    this.turn.needsUpdate = true;
    this.look.needsUpdate = true;
  }
}
