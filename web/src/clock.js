// Which moment of the world belongs to which moment of the sound. The sound's clock leads: it never waits,
// and the world is computed a little ahead of it. Both run at the same rate; what changes is the offset
// between them.

/** How far the world is computed ahead of the sound [s]: the longest that a tick may take to be answered. */
export const LEAD = 0.02;

/** Further behind than this [s], the world does not try to catch up: that would only make it later still. */
const PATIENCE = 0.25;

export class WorldClock {
  constructor() {
    /** Sound time minus world time [s]; null until the first tick and after a stop.
     * @type {number | null} */
    this.offset = null;
    /** Samples per second of the sound. */
    this.sampleRate = 48000;
    /** How often the world was too slow. */
    this.skips = 0;
  }

  /** The next tick starts anew from wherever the world is then. */
  stop() {
    this.offset = null;
  }

  /**
   * The time to which the world has to be computed [s].
   * @param {number} soundTime what has been handed out to be heard [s]
   * @param {number} worldTime where the world is [s]
   */
  due(soundTime, worldTime) {
    if (!Number.isFinite(soundTime)) return worldTime;
    if (this.offset === null) this.offset = this.wholeSamples(soundTime + LEAD - worldTime);
    const due = soundTime + LEAD - this.offset;
    if (due - worldTime > PATIENCE) {
      this.offset = this.wholeSamples(soundTime + LEAD - worldTime);
      this.skips += 1;
      return worldTime;
    }
    return Math.max(due, worldTime);
  }

  /**
   * Offsets are whole numbers of samples, so that a replay gives the very samples that were heard.
   * @param {number} duration [s]
   */
  wholeSamples(duration) {
    return Math.round(duration * this.sampleRate) / this.sampleRate;
  }
}
