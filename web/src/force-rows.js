// Rows of force histories among rows of events. They go to the synthesis as soon as they come, so that it
// does not allocate while it renders; the other rows wait for their time.

import { EVENT, EVENT_KIND, EVENT_STRIDE } from './event-layout.js';

/** Rows handed over at once: 200 kB. */
export const ROWS_AT_ONCE = 1024;

/**
 * Whether a row is part of a force history.
 * @param {Float64Array} rows of `EVENT_STRIDE`
 * @param {number} at first number of the row
 */
export function isForceRow(rows, at) {
  return rows[at + EVENT.kind] === EVENT_KIND.forceHistory;
}

/**
 * Calls `take` with the rows of force histories, in parts.
 * @param {Float64Array} rows
 * @param {(part: Float64Array, count: number) => void} take
 */
export function takeForceRows(rows, take) {
  /** @type {Float64Array | null} */
  let part = null;
  let count = 0;
  for (let at = 0; at + EVENT_STRIDE <= rows.length; at += EVENT_STRIDE) {
    if (!isForceRow(rows, at)) continue;
    part ??= new Float64Array(ROWS_AT_ONCE * EVENT_STRIDE);
    part.set(rows.subarray(at, at + EVENT_STRIDE), count * EVENT_STRIDE);
    count += 1;
    if (count < ROWS_AT_ONCE) continue;
    take(part, count);
    count = 0;
  }
  if (part && count > 0) take(part.subarray(0, count * EVENT_STRIDE), count);
}
