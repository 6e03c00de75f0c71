// Reads the surface of a baked sound model (docs/format/model.md), for drawing and picking. The wasm module
// reads the sound and the mass properties, and checks the file.

/**
 * @typedef {object} Solid
 * @property {string} name
 * @property {string} material
 * @property {Float32Array} vertices [m], from the centre of mass
 * @property {Uint32Array} triangles
 * @property {number} lowest least y of the surface [m]
 * @property {number} radius bounding radius [m]
 */

import { Refusal } from './messages.js';

/** Bytes of the length of the header, before it. */
const LENGTH_BYTES = 8;

/**
 * Opens a safetensors file of Clangor. Throws a `Refusal` for any other file.
 * @param {Uint8Array} bytes
 * @returns {{ about: any, array: (name: string) => ArrayBuffer }} the description, the bytes of each array
 */
export function openTensors(bytes) {
  const header = readHeader(bytes);
  const begin = LENGTH_BYTES + headerLength(bytes);
  const array = (/** @type {string} */ name) => {
    const [from, to] = header[name]?.data_offsets ?? [];
    if (!(from <= to && begin + to <= bytes.length)) {
      throw new Refusal(`the file is incomplete: its part “${name}” is missing`);
    }
    return /** @type {ArrayBuffer} */ (bytes.slice(begin + from, begin + to).buffer);
  };
  return { about: JSON.parse(header.__metadata__.clangor), array };
}

/** @param {Uint8Array} bytes */
function headerLength(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  return bytes.length < LENGTH_BYTES ? Infinity : Number(view.getBigUint64(0, true));
}

/** @param {Uint8Array} bytes @returns {any} */
function readHeader(bytes) {
  const length = headerLength(bytes);
  try {
    const text = new TextDecoder().decode(bytes.subarray(LENGTH_BYTES, LENGTH_BYTES + length));
    const header = length <= bytes.length ? JSON.parse(text) : null;
    // Files of others have no such entry.
    JSON.parse(header.__metadata__.clangor);
    return header;
  } catch {
    throw new Refusal('this is not a file of Clangor');
  }
}

/**
 * @param {Uint8Array} bytes of a sound model
 * @returns {Solid}
 */
export function readSolid(bytes) {
  const { about, array } = openTensors(bytes);
  const vertices = Float32Array.from(new Float64Array(array('solid.vertices')));
  let lowest = Infinity;
  for (let at = 1; at < vertices.length; at += 3) lowest = Math.min(lowest, vertices[at]);
  return {
    name: about.solid.name,
    material: about.modal.origin.material,
    vertices,
    triangles: new Uint32Array(array('solid.triangles')),
    lowest,
    radius: about.acceleration.radius_m,
  };
}
