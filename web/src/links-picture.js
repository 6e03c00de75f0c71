// Draws rods as straight lines and springs as helices.

import {
  BufferAttribute,
  BufferGeometry,
  DynamicDrawUsage,
  Group,
  LineBasicMaterial,
  LineSegments,
  Vector3,
} from 'three';
import { POSE_STRIDE } from './event-layout.js';

/** Straight pieces per turn of a spring, and turns. */
const PIECES = 8;
const TURNS = 12;

export class LinksPicture {
  constructor() {
    this.group = new Group();
    this.material = new LineBasicMaterial({ color: '#aab4c4', transparent: true, opacity: 0.55 });
    /** @type {import('./world.js').Link[]} */
    this.links = [];
    /** @type {import('./world.js').Body[]} */
    this.bodies = [];
  }

  /**
   * @param {import('./world.js').Link[]} links
   * @param {import('./world.js').Body[]} bodies
   */
  setLinks(links, bodies) {
    this.links = links;
    this.bodies = bodies;
    for (const old of this.group.children) /** @type {LineSegments} */ (old).geometry.dispose();
    this.group.clear();
    const pieces = links.reduce((sum, link) => sum + (link.kind === 'rod' ? 1 : PIECES * TURNS), 0);
    if (pieces === 0) return;
    const geometry = new BufferGeometry();
    this.points = new BufferAttribute(new Float32Array(pieces * 6), 3).setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', this.points);
    const lines = new LineSegments(geometry, this.material);
    lines.frustumCulled = false;
    this.group.add(lines);
  }

  /** @param {Float32Array} poses @param {number} known bodies that have a pose */
  update(poses, known) {
    if (!this.points || this.links.length === 0) return;
    const { array } = this.points;
    let at = 0;
    const from = new Vector3();
    const to = new Vector3();
    for (const link of this.links) {
      if (link.body >= known || link.other >= known) continue;
      from.fromArray(poses, link.body * POSE_STRIDE);
      if (link.other >= 0) to.fromArray(poses, link.other * POSE_STRIDE);
      else to.fromArray(link.anchor);
      if (link.kind === 'rod') {
        from.toArray(array, at);
        to.toArray(array, at + 3);
        at += 6;
      } else {
        at = wind(array, at, from, to, 0.3 * (this.bodies[link.body]?.radius ?? 0.01));
      }
    }
    this.points.needsUpdate = true;
  }
}

/**
 * @param {Float32Array | any} array @param {number} at
 * @param {Vector3} from @param {Vector3} to
 * @param {number} radius [m]
 * @returns {number} where the next line goes
 */
function wind(array, at, from, to, radius) {
  const axis = to.clone().sub(from);
  const side = new Vector3(...(Math.abs(axis.x) < 0.9 * axis.length() ? [1, 0, 0] : [0, 1, 0]))
    .cross(axis)
    .normalize();
  const other = axis.clone().normalize().cross(side);
  const steps = PIECES * TURNS;
  const point = (/** @type {number} */ step) => {
    const angle = (2 * Math.PI * step) / PIECES;
    // The ends lie on the axis.
    const width = radius * Math.min(1, (4 * Math.min(step, steps - step)) / PIECES);
    return from
      .clone()
      .addScaledVector(axis, step / steps)
      .addScaledVector(side, width * Math.cos(angle))
      .addScaledVector(other, width * Math.sin(angle));
  };
  let last = point(0);
  for (let step = 1; step <= steps; step += 1) {
    const next = point(step);
    last.toArray(array, at);
    next.toArray(array, at + 3);
    at += 6;
    last = next;
  }
  return at;
}
