// An impact of a small ball, the mallet, on a loaded object at rest: Hertz's contact between them as two free
// bodies.
//
//   m = 1/(1/m₁ + 1/m₂ₑ)   J = (1 + e) m V   τ = 2.87 (m² / (r E*² V))^{1/5}   1/E* = Σ (1 − ν²)/E
//
// m₂ₑ is the effective mass of the object at the point, 1/m₂ₑ = 1/m₂ + (p × n)·I⁻¹(p × n). The object does
// not move: its support is so soft that it vibrates as a free body, and its rigid motion is neglected.

import { EVENT, EVENT_KIND, EVENT_STRIDE } from './event-layout.js';

/** Young's modulus [Pa], Poisson's ratio, density [kg/m³]; as in docs/format/materials.md. */
const ELASTICITY = {
  steel: { modulus: 2.0e11, poisson: 0.29, density: 7850 },
  copper: { modulus: 1.234e11, poisson: 0.34, density: 8940 },
  ceramic: { modulus: 7.2e10, poisson: 0.19, density: 2700 },
  glass: { modulus: 6.2e10, poisson: 0.2, density: 2600 },
  wood: { modulus: 1.24e10, poisson: 0.35, density: 680 },
  rubber: { modulus: 3e6, poisson: 0.49, density: 1100 },
};

/** Mallets. Radius [m]. */
export const MALLETS = {
  steel: { name: 'Steel', material: 'steel', radius: 0.006 },
  wood: { name: 'Wood', material: 'wood', radius: 0.01 },
  rubber: { name: 'Rubber', material: 'rubber', radius: 0.012 },
};

/** Coefficient of restitution of all mallets. */
const RESTITUTION = 0.5;

/**
 * @typedef {object} PlacedSolid
 * @property {import('./model-file.js').Solid} solid
 * @property {number} slot
 * @property {number} key its number in contacts; negative beside a world with bodies of its own
 * @property {number[]} position of the centre of mass [m]
 */

/**
 * @param {PlacedSolid} object not turned
 * @param {number[]} point on its surface, world [m]
 * @param {number[]} normal out of the surface, of length 1
 * @param {number} speed [m/s]
 * @param {keyof typeof MALLETS} malletName
 * @returns {{ event: Float64Array, impulse: number, duration: number }} [N s], [s]; without the event's time
 */
export function strike(object, point, normal, speed, malletName) {
  const { solid } = object;
  const mallet = MALLETS[malletName];
  const own = ELASTICITY[/** @type {keyof typeof ELASTICITY} */ (mallet.material)];
  const other = ELASTICITY[/** @type {keyof typeof ELASTICITY} */ (solid.material)];
  const malletMass = (4 / 3) * Math.PI * mallet.radius ** 3 * own.density;

  const arm = point.map((x, axis) => x - object.position[axis]);
  const twist = cross(arm, normal);
  const inverseMass =
    1 / malletMass +
    1 / solid.mass +
    twist.reduce((sum, component, axis) => sum + component ** 2 / solid.inertia[axis], 0);
  const size = ((1 + RESTITUTION) * speed) / inverseMass;
  const impulse = normal.map((component) => -component * size);
  const compliance = (1 - own.poisson ** 2) / own.modulus + (1 - other.poisson ** 2) / other.modulus;
  const duration = 2.87 * (compliance ** 2 / (mallet.radius * inverseMass ** 2 * speed)) ** 0.2;

  const event = new Float64Array(EVENT_STRIDE);
  event[EVENT.kind] = EVENT_KIND.objectImpact;
  event[EVENT.duration] = duration;
  event[EVENT.slot] = object.slot;
  event.set(object.position, EVENT.centre);
  event.set([0, 0, 0, 1], EVENT.orientation);
  event.set(
    impulse.map((component) => component / solid.mass),
    EVENT.velocityChange,
  );
  event.set(
    cross(arm, impulse).map((component, axis) => component / solid.inertia[axis]),
    EVENT.angularVelocityChange,
  );
  event.set(point, EVENT.point);
  event.set(impulse, EVENT.impulse);
  event[EVENT.body] = object.slot;
  return { event, impulse: size, duration };
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

/** @param {number[]} a @param {number[]} b */
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
