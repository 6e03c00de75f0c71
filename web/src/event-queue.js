// Queue of events ordered by time: a binary heap of fixed size. The audio thread does not allocate, and its
// work is bounded: events that do not fit, or have no valid time, are counted and dropped.

import { EVENT, EVENT_STRIDE } from './event-layout.js';
import { isForceRow } from './force-rows.js';

export class EventQueue {
  /** @param {number} capacity events */
  constructor(capacity) {
    this.capacity = capacity;
    this.events = new Float64Array(capacity * EVENT_STRIDE);
    this.times = new Float64Array(capacity);
    // Events of equal time keep the order of arrival.
    this.arrivals = new Float64Array(capacity);
    this.heap = new Int32Array(capacity);
    this.free = new Int32Array(capacity);
    this.arrival = 0;
    this.dropped = 0;
    this.clear();
  }

  clear() {
    this.count = 0;
    for (let slot = 0; slot < this.capacity; slot += 1) this.free[slot] = slot;
  }

  /**
   * Adds events; rows of force histories are left out, as they do not wait.
   * @param {Float64Array} events rows of `EVENT_STRIDE`
   */
  add(events) {
    const rows = Math.floor(events.length / EVENT_STRIDE);
    for (let row = 0; row < rows; row += 1) {
      const at = row * EVENT_STRIDE;
      if (isForceRow(events, at)) continue;
      if (this.count === this.capacity) {
        this.dropped += 1;
        continue;
      }
      const time = events[at + EVENT.time];
      if (!Number.isFinite(time)) {
        this.dropped += 1;
        continue;
      }
      const slot = this.free[this.capacity - this.count - 1];
      for (let i = 0; i < EVENT_STRIDE; i += 1) {
        this.events[slot * EVENT_STRIDE + i] = events[at + i];
      }
      this.times[slot] = time;
      this.arrivals[slot] = this.arrival;
      this.arrival += 1;
      this.heap[this.count] = slot;
      this.count += 1;
      this.rise(this.count - 1);
    }
  }

  /**
   * Moves the events before `time` into `target`.
   * @param {number} time [s]
   * @param {Float64Array} target
   * @returns {number} events moved: as many as are due and fit
   */
  take(time, target) {
    const most = Math.floor(target.length / EVENT_STRIDE);
    let taken = 0;
    while (taken < most && this.count > 0 && this.times[this.heap[0]] < time) {
      const slot = this.heap[0];
      for (let i = 0; i < EVENT_STRIDE; i += 1) {
        target[taken * EVENT_STRIDE + i] = this.events[slot * EVENT_STRIDE + i];
      }
      taken += 1;
      this.count -= 1;
      this.free[this.capacity - this.count - 1] = slot;
      this.heap[0] = this.heap[this.count];
      this.sink(0);
    }
    return taken;
  }

  /** @param {number} a @param {number} b slots */
  before(a, b) {
    const difference = this.times[a] - this.times[b];
    return difference < 0 || (difference === 0 && this.arrivals[a] < this.arrivals[b]);
  }

  /** @param {number} at */
  rise(at) {
    while (at > 0) {
      const parent = (at - 1) >> 1;
      if (!this.before(this.heap[at], this.heap[parent])) return;
      this.swap(at, parent);
      at = parent;
    }
  }

  /** @param {number} at */
  sink(at) {
    for (;;) {
      let first = at;
      for (const child of [2 * at + 1, 2 * at + 2]) {
        if (child < this.count && this.before(this.heap[child], this.heap[first])) first = child;
      }
      if (first === at) return;
      this.swap(at, first);
      at = first;
    }
  }

  /** @param {number} a @param {number} b positions in the heap */
  swap(a, b) {
    const slot = this.heap[a];
    this.heap[a] = this.heap[b];
    this.heap[b] = slot;
  }
}
