// Layout of the rows of numbers that wasm module, worker, worklet and page exchange.
// SI units. Generated from crates/clangor-web/src/layout.rs; do not edit:
//   cargo run -p clangor-web --example event-layout > web/src/event-layout.js

/** Numbers per row of an event (f64). */
export const EVENT_STRIDE = 25;

/** Offsets within an event. */
export const EVENT = {
  /** One of `EVENT_KIND`. */
  kind: 0,
  /** Time [s], on the clock of the holder of the event. */
  time: 1,
  /** Duration of the force [s]. */
  duration: 2,
  /** Radius [m] of a sphere. */
  radius: 3,
  /** Slot of a loaded object, in the place of the radius. */
  slot: 3,
  /** Centre of mass [m], 3 numbers. */
  centre: 4,
  /** Quaternion x, y, z, w. */
  orientation: 7,
  /** Change of the velocity [m/s], 3 numbers; of a pose the velocity. */
  velocityChange: 11,
  /** Change of the angular velocity [rad/s], 3 numbers; of a pose the angular velocity. */
  angularVelocityChange: 14,
  /** Point of the impact [m], 3 numbers. */
  point: 17,
  /** Impulse on the body [N s], 3 numbers. */
  impulse: 20,
  /** Number of the body; the engine ignores it. */
  body: 23,
  /** Number of the force history; 0 for the engine's profile. */
  history: 24,
  /** Number of samples of a force history. */
  count: 2,
  /** Time of its first sample after the onset [s]. */
  start: 3,
  /** Distance of its samples [s]. */
  step: 4,
  /** Index of the first sample of the row. */
  first: 5,
  /** Samples [1/s] of a force of unit impulse, up to 17 numbers. */
  samples: 6,
};

/** Kinds of events. */
export const EVENT_KIND = {
  /** An impact on a sphere. */
  sphereImpact: 0,
  /** An impact on a loaded object. */
  objectImpact: 1,
  /** The motion of a loaded object from a time on. */
  pose: 2,
  /** The end of a loaded object. */
  end: 3,
  /** A part of a force history. */
  forceHistory: 4,
};

/** Numbers per contact (f64). */
export const CONTACT_STRIDE = 12;

/** Offsets within a contact. */
export const CONTACT = {
  /** Onset [s]. */
  time: 0,
  /** Number of the first body. */
  bodyA: 1,
  /** Number of the second body; −1 for the immovable world. */
  bodyB: 2,
  /** Approach speed [m/s]. */
  speed: 3,
  /** Normal impulse [N s]. */
  impulse: 4,
  /** Duration of the force [s]. */
  duration: 5,
  /** Point of the contact [m], 3 numbers. */
  point: 6,
  /** Effective mass [kg]. */
  mass: 9,
};

/** Numbers per pose (f32): position [m], then quaternion x, y, z, w. */
export const POSE_STRIDE = 7;

/** Numbers per body (f64). */
export const BODY_STRIDE = 8;

/** Numbers per rod or spring (f64). */
export const LINK_STRIDE = 8;

/** Numbers of the report of the synthesis (f64). */
export const REPORT_STRIDE = 13;
