// Outputs the events of a replay at their times: a sorted list in world time and a map from world time to
// audio time, at full speed or slower. A slow replay stretches the world time only; single sounds keep their
// length.

import { EVENT, EVENT_STRIDE } from './event-layout.js';
import { isForceRow } from './force-rows.js';

export class ReplayFeeder {
  constructor() {
    this.stop();
  }

  stop() {
    this.events = new Float64Array(0);
    this.at = 0;
  }

  /**
   * @param {Float64Array} events in order of time, on the world's clock; those before `from` are due at once
   * @param {number} from world time [s] that is audible …
   * @param {number} rate seconds of the world per second of sound
   * @param {number} earliest … at this audio time [s], or up to one sample later, so that the shift is a
   *   whole number of samples and the samples are identical to the first ones
   * @param {number} samplesPerSecond
   */
  start(events, from, rate, earliest, samplesPerSecond) {
    this.events = events;
    this.at = 0;
    this.from = from;
    this.rate = rate;
    this.soundTime = from + Math.ceil((earliest - from) * samplesPerSecond) / samplesPerSecond;
  }

  /**
   * Moves the events before `time` into `target`, on the clock of the sound, without rows of force histories.
   * @param {number} time [s]
   * @param {Float64Array} target
   * @returns {number} events moved: as many as are due and fit
   */
  take(time, target) {
    const rows = this.events.length / EVENT_STRIDE;
    const most = target.length / EVENT_STRIDE;
    let taken = 0;
    while (taken < most && this.at < rows) {
      const row = this.at * EVENT_STRIDE;
      if (isForceRow(this.events, row)) {
        this.at += 1;
        continue;
      }
      const due = this.soundTime + (this.events[row + EVENT.time] - this.from) / this.rate;
      if (due >= time) break;
      target.set(this.events.subarray(row, row + EVENT_STRIDE), taken * EVENT_STRIDE);
      target[taken * EVENT_STRIDE + EVENT.time] = due;
      taken += 1;
      this.at += 1;
    }
    return taken;
  }
}
