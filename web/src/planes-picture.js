// Draws the fixed planes, each clipped by all others and by the drawn extent, so that the inside of a
// container remains. Planes that face up are surfaces with a grid of decimetres, walls are outlines.

import {
  AdditiveBlending,
  BufferGeometry,
  Color,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineLoop,
  Mesh,
  MeshBasicMaterial,
  ShaderMaterial,
  Vector3,
} from 'three';
import { lookOf } from './looks.js';

const GROUND_VERTEX = /* glsl */ `
  varying vec3 vAt;
  void main() {
    vAt = position;
    gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
  }
`;

const GROUND_FRAGMENT = /* glsl */ `
  uniform vec3 colour;
  uniform vec3 centre;
  uniform float reach;
  uniform float grid;
  varying vec3 vAt;
  float line(float x, float width) {
    float away = abs(fract(x - 0.5) - 0.5) / max(width, 1e-6);
    return 1.0 - smoothstep(0.4, 1.2, away);
  }
  void main() {
    float r = length(vAt.xz - centre.xz) / reach;
    float lit = exp(-1.7 * r * r);
    vec2 cell = vAt.xz / grid;
    vec2 width = fwidth(cell);
    float near = 1.0 - smoothstep(0.15, 0.5, max(width.x, width.y));
    float lines = max(line(cell.x, width.x), line(cell.y, width.y)) * near;
    vec3 shade = colour * (0.18 + 0.62 * lit) + vec3(0.022) * lines * lit;
    gl_FragColor = vec4(shade, 1.0 - smoothstep(0.75, 1.0, r));
    #include <colorspace_fragment>
  }
`;

/**
 * @typedef {object} Extent
 * @property {number[]} low corner of the part of the world that is drawn [m]
 * @property {number[]} high
 */

export class PlanesPicture {
  constructor() {
    this.group = new Group();
    /** Height of the highest ground, or −∞ [m]. */
    this.floorHeight = -Infinity;
  }

  /**
   * @param {import('./world.js').Body[]} bodies
   * @param {{ name: string }[]} materials
   * @param {Extent} extent
   */
  setBodies(bodies, materials, extent) {
    for (const old of this.group.children) /** @type {Mesh} */ (old).geometry.dispose();
    this.group.clear();
    this.floorHeight = -Infinity;
    const planes = bodies.filter((body) => body.plane);
    for (const plane of planes) {
      const corners = cutPlane(plane, planes, extent);
      if (corners.length < 3) continue;
      const { colour } = lookOf(materials[plane.material]?.name ?? '', 0);
      if (plane.normal[1] > 0.999) {
        this.floorHeight = Math.max(this.floorHeight, plane.distance);
        this.group.add(ground(corners, colour, extent));
      } else {
        this.group.add(...wall(corners, plane.normal[1] > 0.2));
      }
    }
  }
}

/** @param {Vector3[]} corners @param {Color} colour @param {Extent} extent */
function ground(corners, colour, extent) {
  const size = Math.max(extent.high[0] - extent.low[0], extent.high[2] - extent.low[2]);
  const material = new ShaderMaterial({
    vertexShader: GROUND_VERTEX,
    fragmentShader: GROUND_FRAGMENT,
    uniforms: {
      colour: { value: colour },
      centre: { value: middle(corners) },
      reach: { value: size * 0.72 },
      grid: { value: size > 1 ? 0.25 : 0.1 },
    },
    transparent: true,
    side: DoubleSide,
  });
  const mesh = new Mesh(fan(corners), material);
  mesh.renderOrder = -2;
  return mesh;
}

/** An outline, and a pane for a slope. @param {Vector3[]} corners @param {boolean} slope */
function wall(corners, slope) {
  const outline = new LineLoop(
    new BufferGeometry().setFromPoints(corners),
    new LineBasicMaterial({ color: '#8fa0b8', transparent: true, opacity: 0.4 }),
  );
  if (!slope) return [outline];
  const look = { color: '#8fa0b8', transparent: true, opacity: 0.09, depthWrite: false };
  const pane = new Mesh(
    fan(corners),
    new MeshBasicMaterial({ ...look, side: DoubleSide, blending: AdditiveBlending }),
  );
  pane.renderOrder = -1;
  return [outline, pane];
}

/** @param {Vector3[]} corners */
function middle(corners) {
  const sum = corners.reduce((total, corner) => total.add(corner), new Vector3());
  return sum.divideScalar(corners.length);
}

/** A convex polygon as triangles. @param {Vector3[]} corners */
function fan(corners) {
  const geometry = new BufferGeometry();
  const numbers = corners.flatMap((corner) => corner.toArray());
  geometry.setAttribute('position', new Float32BufferAttribute(numbers, 3));
  const index = [];
  for (let i = 2; i < corners.length; i += 1) index.push(0, i - 1, i);
  geometry.setIndex(index);
  return geometry;
}

/**
 * The part of a plane inside the other planes and the extent.
 * @param {import('./world.js').Body} plane
 * @param {import('./world.js').Body[]} planes
 * @param {Extent} extent
 * @returns {Vector3[]} corners of a convex polygon
 */
function cutPlane(plane, planes, extent) {
  const normal = new Vector3(...plane.normal);
  const middleOfExtent = new Vector3(...extent.low).add(new Vector3(...extent.high)).divideScalar(2);
  const foot = middleOfExtent.clone().addScaledVector(normal, plane.distance - normal.dot(middleOfExtent));
  const across = new Vector3(...(Math.abs(normal.y) < 0.9 ? [0, 1, 0] : [1, 0, 0])).cross(normal).normalize();
  const along = normal.clone().cross(across);
  const far = 4 * new Vector3(...extent.high).distanceTo(new Vector3(...extent.low));
  let corners = [
    [-far, -far],
    [far, -far],
    [far, far],
    [-far, far],
  ].map(([a, b]) => foot.clone().addScaledVector(across, a).addScaledVector(along, b));
  for (const other of planes) {
    if (other === plane) continue;
    corners = keepAbove(corners, new Vector3(...other.normal), other.distance);
  }
  for (const [axis, unit] of [
    [0, new Vector3(1, 0, 0)],
    [1, new Vector3(0, 1, 0)],
    [2, new Vector3(0, 0, 1)],
  ]) {
    const at = /** @type {number} */ (axis);
    const direction = /** @type {Vector3} */ (unit);
    corners = keepAbove(corners, direction, extent.low[at]);
    corners = keepAbove(corners, direction.clone().negate(), -extent.high[at]);
  }
  return corners;
}

/**
 * Cuts a convex polygon by a half-space (Sutherland and Hodgman).
 * @param {Vector3[]} corners
 * @param {Vector3} normal
 * @param {number} distance
 */
function keepAbove(corners, normal, distance) {
  /** @type {Vector3[]} */
  const kept = [];
  corners.forEach((corner, i) => {
    const next = corners[(i + 1) % corners.length];
    const height = normal.dot(corner) - distance;
    const nextHeight = normal.dot(next) - distance;
    if (height >= -1e-9) kept.push(corner);
    if (height < -1e-9 !== nextHeight < -1e-9) {
      kept.push(corner.clone().lerp(next, height / (height - nextHeight)));
    }
  });
  return kept;
}
