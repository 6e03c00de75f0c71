// The last half minute of the world, for drawing the audible moment and for replay: poses, contacts and sound
// events. All times are those of the world.

import { CONTACT, CONTACT_STRIDE, EVENT, EVENT_KIND, EVENT_STRIDE, POSE_STRIDE } from './event-layout.js';

/** Duration kept [s]. */
export const KEPT = 30;

/** Largest number of values in the poses: 96 MB. With thousands of bodies that is less than half a minute. */
const MOST_POSE_NUMBERS = 24e6;

/**
 * @typedef {object} Contact
 * @property {number} time [s]
 * @property {number} bodyA
 * @property {number} bodyB −1 for the world
 * @property {number} speed [m/s]
 * @property {number} impulse [N s]
 * @property {number} duration [s]
 * @property {number[]} point [m]
 */

export class History {
  constructor() {
    this.clear();
  }

  clear() {
    /** @type {{ time: number, poses: Float32Array }[]} */
    this.frames = [];
    /** @type {Contact[]} */
    this.contacts = [];
    /** @type {{ time: number, event: Float64Array }[]} */
    this.events = [];
    /** @type {number} */
    this.poseNumbers = 0;
  }

  get start() {
    return this.frames.length > 0 ? this.frames[0].time : 0;
  }

  get end() {
    return this.frames.length > 0 ? this.frames[this.frames.length - 1].time : 0;
  }

  /** @param {import('./world.js').Frame} frame */
  add(frame) {
    this.frames.push({ time: frame.time, poses: frame.poses });
    this.poseNumbers += frame.poses.length;
    for (let at = 0; at < frame.contacts.length; at += CONTACT_STRIDE) {
      this.contacts.push(readContact(frame.contacts, at));
    }
    for (let at = 0; at < frame.events.length; at += EVENT_STRIDE) {
      this.addEvent(frame.events.slice(at, at + EVENT_STRIDE));
    }
    this.forget();
  }

  /**
   * Holds a finished run, all of it.
   * @param {{ time: number, poses: Float32Array }[]} frames
   * @param {Contact[]} contacts
   * @param {Float64Array[]} events
   */
  fill(frames, contacts, events) {
    this.clear();
    this.frames = frames;
    this.contacts = contacts;
    for (const event of events) this.addEvent(event);
  }

  /** Inserts a contact in order of time. @param {Contact} contact */
  addContact(contact) {
    const { contacts } = this;
    let at = contacts.length;
    while (at > 0 && contacts[at - 1].time > contact.time) at -= 1;
    contacts.splice(at, 0, contact);
  }

  /** @param {Float64Array} event one row, on the world's clock */
  addEvent(event) {
    this.events.push({ time: event[EVENT.time], event });
  }

  forget() {
    const { frames } = this;
    let stale = 0;
    let numbers = this.poseNumbers;
    while (
      stale < frames.length - 2 &&
      (frames[stale + 1].time < this.end - KEPT || numbers > MOST_POSE_NUMBERS)
    ) {
      numbers -= frames[stale].poses.length;
      stale += 1;
    }
    // Removed in batches, because removal at the front moves all other entries.
    if (stale < 100 && this.poseNumbers <= MOST_POSE_NUMBERS) return;
    this.poseNumbers = numbers;
    frames.splice(0, stale);
    dropBefore(this.contacts, this.start);
    dropBefore(this.events, this.start);
  }

  /**
   * Writes the poses at a time into `target`, as many as fit, linear between two frames.
   * @param {number} time [s]
   * @param {Float32Array} target rows of `POSE_STRIDE`
   * @returns {number} bodies written
   */
  poses(time, target) {
    const { frames } = this;
    if (frames.length === 0) return 0;
    const next = firstAtOrAfter(frames, time);
    const after = frames[Math.min(next, frames.length - 1)];
    const before = frames[Math.max(0, Math.min(next, frames.length) - 1)];
    const span = after.time - before.time;
    const part = span > 0 ? Math.min(1, Math.max(0, (time - before.time) / span)) : 0;
    const length = Math.min(after.poses.length, target.length);
    for (let at = 0; at < length; at += POSE_STRIDE) {
      // A body that has just been added has no earlier pose.
      const from = at < before.poses.length ? before.poses : after.poses;
      interpolatePose(from, after.poses, at, part, target);
    }
    return length / POSE_STRIDE;
  }

  /**
   * Contacts with `after` < time ≤ `until`.
   * @param {number} after [s]
   * @param {number} until [s]
   */
  contactsBetween(after, until) {
    const { contacts } = this;
    const found = [];
    for (let i = contacts.length - 1; i >= 0 && contacts[i].time > after; i -= 1) {
      if (contacts[i].time <= until) found.push(contacts[i]);
    }
    return found.reverse();
  }

  /**
   * The events from a time on, as rows in order of time, preceded by the last pose of each loaded object.
   * @param {number} from [s]
   */
  eventsFrom(from) {
    const inOrder = this.events.toSorted((a, b) => a.time - b.time);
    /** @type {Map<number, { time: number, event: Float64Array }>} */
    const lastPoses = new Map();
    for (const entry of inOrder) {
      if (entry.time >= from) break;
      const { event } = entry;
      if (event[EVENT.kind] === EVENT_KIND.pose) lastPoses.set(event[EVENT.slot], entry);
      if (event[EVENT.kind] === EVENT_KIND.end) lastPoses.delete(event[EVENT.slot]);
    }
    const chosen = [...lastPoses.values(), ...inOrder.filter((entry) => entry.time >= from)];
    const rows = new Float64Array(chosen.length * EVENT_STRIDE);
    chosen.forEach((entry, row) => rows.set(entry.event, row * EVENT_STRIDE));
    return rows;
  }
}

/** @param {Float64Array} rows @param {number} at @returns {Contact} */
export function readContact(rows, at) {
  return {
    time: rows[at + CONTACT.time],
    bodyA: rows[at + CONTACT.bodyA],
    bodyB: rows[at + CONTACT.bodyB],
    speed: rows[at + CONTACT.speed],
    impulse: rows[at + CONTACT.impulse],
    duration: rows[at + CONTACT.duration],
    point: [...rows.subarray(at + CONTACT.point, at + CONTACT.point + 3)],
  };
}

/** @param {{ time: number }[]} entries in order of time @param {number} time */
function firstAtOrAfter(entries, time) {
  let low = 0;
  let high = entries.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (entries[middle].time < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** @param {{ time: number }[]} entries in order of time @param {number} time */
function dropBefore(entries, time) {
  entries.splice(0, firstAtOrAfter(entries, time));
}

/**
 * @param {Float32Array} from @param {Float32Array} to @param {number} at
 * @param {number} part 0 to 1
 * @param {Float32Array} target
 */
function interpolatePose(from, to, at, part, target) {
  for (let i = 0; i < 3; i += 1) {
    target[at + i] = from[at + i] + (to[at + i] - from[at + i]) * part;
  }
  let dot = 0;
  for (let i = 3; i < 7; i += 1) dot += from[at + i] * to[at + i];
  const sign = dot < 0 ? -1 : 1;
  let square = 0;
  for (let i = 3; i < 7; i += 1) {
    const component = from[at + i] * (1 - part) + sign * to[at + i] * part;
    target[at + i] = component;
    square += component * component;
  }
  const scale = square > 0 ? 1 / Math.sqrt(square) : 1;
  for (let i = 3; i < 7; i += 1) target[at + i] *= scale;
}
