// Adds falling balls to the scene at regular world times, up to a number. Then it throws the oldest ball up
// again. Deterministic: every run of a scene is the same.

import { addSphere } from './add-sphere.js';

/**
 * @typedef {object} RainSettings
 * @property {number} interval between two balls [s]
 * @property {number} most balls that are added
 * @property {number[]} materials indices into the materials of the world
 * @property {[number, number]} radii least and largest radius [m]
 * @property {[number[], number[]]} region corners of the box in which they appear [m]
 */

export class Rain {
  /** @param {RainSettings} settings */
  constructor(settings) {
    this.settings = settings;
    this.next = 0;
    this.random = randomNumbers(20);
    /** @type {number[]} */
    this.bodies = [];
    this.oldest = 0;
  }

  /**
   * @param {import('./wasm-instance.js').WasmInstance} world
   * @returns {boolean} whether a body was added
   */
  fall(world) {
    const { exports } = world;
    const now = exports.world_time();
    if (now < this.next) return false;
    const { interval, most, materials, radii, region } = this.settings;
    this.next = now + interval;
    if (this.bodies.length >= most) {
      exports.world_set_velocity(this.bodies[this.oldest], 0, 2.2, 0);
      this.oldest = (this.oldest + 1) % this.bodies.length;
      return false;
    }
    const between = (/** @type {number} */ low, /** @type {number} */ high) =>
      low + (high - low) * this.random();
    const [low, high] = region;
    const position = low.map((least, axis) => between(least, high[axis]));
    const material = materials[this.bodies.length % materials.length];
    // Negative where another ball occupies the position; the next try follows soon.
    const body = addSphere(world, material, between(...radii), position, [0, 0, 0]);
    if (body < 0) return false;
    this.bodies.push(body);
    return true;
  }
}

/** Uniform numbers from 0 to 1 (mulberry32).
 * @param {number} seed */
export function randomNumbers(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}
