/**
 * Adds a ball to the world.
 * @param {import('./wasm-instance.js').WasmInstance} world
 * @param {number} material its index
 * @param {number} radius [m]
 * @param {number[]} position of the centre [m]
 * @param {number[]} velocity [m/s]
 * @returns {number} its number; negative if the module refuses
 */
export function addSphere(world, material, radius, position, velocity) {
  world.writeNumbers(Float64Array.of(radius, ...position, ...velocity));
  return world.exports.world_add_sphere(material);
}
