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

/**
 * Opens a safetensors file of Clangor.
 * @param {Uint8Array} bytes
 * @returns {{ about: any, array: (name: string) => ArrayBuffer }} the description, the bytes of each array
 */
export function openTensors(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const headerLength = Number(view.getBigUint64(0, true));
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + headerLength)));
  const array = (/** @type {string} */ name) => {
    const [begin, end] = header[name].data_offsets;
    return /** @type {ArrayBuffer} */ (bytes.slice(8 + headerLength + begin, 8 + headerLength + end).buffer);
  };
  return { about: JSON.parse(header.__metadata__.clangor), array };
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
