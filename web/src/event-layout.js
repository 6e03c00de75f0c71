// Where the numbers of an event and of a contact lie: the plain arrays that travel between the wasm module,
// the worker, the worklet and the page. SI units. Must agree with crates/clangor-web.

/** Numbers per event (f64). */
export const EVENT_STRIDE = 24;

/** Offsets within an event. */
export const EVENT = {
  /** One of `EVENT_KIND`. */
  kind: 0,
  /** [s], on the clock that whoever holds the event says. */
  time: 1,
  /** How long the force of the impact lasts [s]. */
  duration: 2,
  /** Radius of a sphere [m]. */
  radius: 3,
  /** Slot of a loaded object (in the place of the radius). */
  slot: 3,
  /** Centre of mass [m], 3 numbers. */
  centre: 4,
  /** Quaternion x, y, z, w. */
  orientation: 7,
  /** Change of velocity in the impact [m/s]; velocity, in a pose. 3 numbers. */
  velocityChange: 11,
  /** Change of angular velocity [rad/s], 3 numbers. */
  spinChange: 14,
  /** Where the impact acts [m], 3 numbers. */
  point: 17,
  /** Impulse on the body [N s], 3 numbers. */
  impulse: 20,
  /** Number of the body. */
  body: 23,
};

/** Kinds of events: a sphere that is hit, a loaded object that is hit, where one is, and when one is no more. */
export const EVENT_KIND = { click: 0, impact: 1, pose: 2, end: 3 };

/** Numbers per contact (f64). */
export const CONTACT_STRIDE = 12;

/** Offsets within a contact. */
export const CONTACT = {
  /** [s] */
  time: 0,
  bodyA: 1,
  /** −1 for the immovable world. */
  bodyB: 2,
  /** Approach speed [m/s]. */
  speed: 3,
  /** Normal impulse [N s]. */
  impulse: 4,
  /** How long the contact lasts [s]. */
  duration: 5,
  /** Where [m], 3 numbers. */
  point: 6,
  /** Effective mass [kg]. */
  mass: 9,
};

/** Numbers per pose (f32): position [m], then quaternion x, y, z, w. */
export const POSE_STRIDE = 7;

/**
 * Adds to the time of every row.
 * @param {Float64Array} rows
 * @param {number} stride numbers per row
 * @param {number} timeOffset where the time is in a row
 * @param {number} shift [s]
 */
export function shiftTimes(rows, stride, timeOffset, shift) {
  for (let at = timeOffset; at < rows.length; at += stride) rows[at] += shift;
}
