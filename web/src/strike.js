// Impacts of a small ball, the mallet, on loaded objects. clangor.wasm computes their forces: see strike.rs
// of crates/clangor-web.

import { CONTACT_STRIDE, EVENT, EVENT_KIND, EVENT_STRIDE } from './event-layout.js';
import { WasmInstance } from './wasm-instance.js';

/** Mallets: name on the page, material of the library, radius [m]. */
export const MALLETS = {
  steel: { name: 'Steel', material: 'steel', radius: 0.006 },
  wood: { name: 'Wood', material: 'wood', radius: 0.01 },
  rubber: { name: 'Rubber', material: 'rubber', radius: 0.012 },
};

/**
 * @typedef {object} PlacedSolid
 * @property {import('./model-file.js').Solid} solid
 * @property {number} slot
 * @property {number} key its number in contacts; negative beside a world with bodies of its own
 * @property {number[]} position of the centre of mass [m]
 */

export class Strikes {
  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.wasm = new WasmInstance(module);
    this.wasm.check(this.wasm.exports.strike_materials());
    /** @type {string[]} */
    this.materials = JSON.parse(this.wasm.message());
  }

  /** @param {number} slot @param {Uint8Array} bytes of a sound model */
  load(slot, bytes) {
    this.wasm.check(this.wasm.exports.strike_load(slot, this.wasm.writeBytes(bytes)));
  }

  /**
   * @param {PlacedSolid} object not turned
   * @param {number[]} point on its surface, world [m]
   * @param {number} speed [m/s]
   * @param {keyof typeof MALLETS} malletName
   * @returns {{ events: Float64Array, contact: Float64Array }} rows at time 0: of the object and the mallet
   */
  impact(object, point, speed, malletName) {
    const { material, radius } = MALLETS[malletName];
    this.wasm.writeNumbers(new Float64Array([radius, speed, ...object.position, ...point]));
    const { exports } = this.wasm;
    const count = this.wasm.check(exports.strike_impact(object.slot, this.materials.indexOf(material)));
    return {
      events: this.wasm.readNumbers(exports.strike_events(), count * EVENT_STRIDE),
      contact: this.wasm.readNumbers(exports.strike_contact(), CONTACT_STRIDE),
    };
  }
}

/**
 * The pose event of an object at rest.
 * @param {PlacedSolid} object
 */
export function restingPose(object) {
  const event = new Float64Array(EVENT_STRIDE);
  event[EVENT.kind] = EVENT_KIND.pose;
  event[EVENT.slot] = object.slot;
  event.set(object.position, EVENT.centre);
  event.set([0, 0, 0, 1], EVENT.orientation);
  event[EVENT.body] = object.slot;
  return event;
}
