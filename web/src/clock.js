// Maps world time to audio time. The audio clock is the master: it never waits, and the world is simulated
// slightly ahead of it. Both run at the same rate; only the offset between them changes.

/** Time by which the world is ahead of the sound [s]; upper bound of the response time to a tick. */
export const LEAD = 0.02;

/** Delay [s] above which the world skips time instead of catching up. */
const PATIENCE = 0.25;

export class WorldClock {
  constructor() {
    /** Sound time minus world time [s]; null until the first tick and after a stop.
     * @type {number | null} */
    this.offset = null;
    /** Samples per second of the sound. */
    this.sampleRate = 48000;
    /** Number of time skips. */
    this.skips = 0;
  }

  /** The next tick sets a new offset from the world time then reached. */
  stop() {
    this.offset = null;
  }

  /**
   * The time to which the world must be simulated [s].
   * @param {number} soundTime audio time rendered so far [s]
   * @param {number} worldTime time reached by the world [s]
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
   * Offsets are whole numbers of samples, so that a replay gives identical samples.
   * @param {number} duration [s]
   */
  wholeSamples(duration) {
    return Math.round(duration * this.sampleRate) / this.sampleRate;
  }
}
