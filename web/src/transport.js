// Controls which world time is shown and audible: live, or a time in the last half minute, paused or replayed
// at full speed or slower.

/** @typedef {'live' | 'paused' | 'replaying'} Mode */

export class Transport extends EventTarget {
  /**
   * @param {import('./world.js').World} world
   * @param {import('./sound.js').Sound} sound
   * @param {import('./history.js').History} history
   */
  constructor(world, sound, history) {
    super();
    this.world = world;
    this.sound = sound;
    this.history = history;
    /** @type {Mode} */
    this.mode = 'live';
    this.rate = 1;
    /** Whether the history holds a finished run, without a live world. */
    this.finished = false;
    /** World time of the pause or of the start of the replay [s]. */
    this.moment = 0;
    /** Audio time at which that world time is rendered [s]; null until the worklet reports it.
     * @type {number | null} */
    this.startedAt = null;
    /** Whether the sound, when it comes on, plays from `moment`. */
    this.playsWithSound = false;
    /** Time of the clock that drives the world minus time of the world, as of the last frame [s].
     * @type {number | null} */
    this.offset = null;
    /** That clock. @type {'page' | 'sound'} */
    this.driver = 'page';
    sound.addEventListener('replaying', (event) => {
      const { from, at } = /** @type {CustomEvent} */ (event).detail;
      if (this.mode === 'replaying' && from === this.moment) this.startedAt = at;
    });
    sound.addEventListener('on', () => {
      if (this.playsWithSound) this.play();
    });
  }

  /** @param {import('./world.js').Frame} frame the newest one of the live world */
  follow({ offset, driver }) {
    this.offset = offset;
    this.driver = driver;
  }

  /** Audio time at the source of the sound that is audible now [s]. */
  heard() {
    if (!this.sound.on) return performance.now() / 1000;
    return this.sound.audibleTime() - this.sound.latency;
  }

  /** World time that is audible and shown [s]. */
  shown() {
    const { history } = this;
    switch (this.mode) {
      case 'live': {
        // Until the world has changed over to the clock of the sound, its offset is that of another clock.
        if (this.offset === null || (this.driver === 'sound') !== this.sound.on) return history.end;
        return Math.min(history.end, Math.max(history.start, this.heard() - this.offset));
      }
      case 'paused':
        return this.moment;
      case 'replaying': {
        if (this.startedAt === null) return this.moment;
        const passed = Math.max(0, this.heard() - this.startedAt);
        const time = this.moment + passed * this.rate;
        if (time >= history.end) {
          this.pauseAt(history.end);
          return history.end;
        }
        return time;
      }
    }
  }

  goLive() {
    if (this.mode === 'live' || this.finished) return;
    this.playsWithSound = false;
    this.change('live');
    this.sound.post({ kind: 'silence' });
    this.world.run(true);
  }

  /** @param {number} time [s of the world] */
  pauseAt(time) {
    this.moment = Math.min(this.history.end, Math.max(this.history.start, time));
    this.startedAt = null;
    this.playsWithSound = false;
    this.world.run(false);
    if (this.mode !== 'paused') {
      this.change('paused');
      this.sound.post({ kind: 'silence' });
    }
  }

  pause() {
    this.pauseAt(this.shown());
  }

  play() {
    if (this.moment >= this.history.end - 0.01) this.moment = this.history.start;
    this.world.run(false);
    // A replay that began in silence begins again with the sound; a finished run waits for it.
    this.playsWithSound = !this.sound.on;
    if (this.playsWithSound && this.finished && !this.sound.refused) return;
    this.change('replaying');
    if (this.sound.on) {
      this.startedAt = null;
      const events = this.history.eventsFrom(this.moment);
      const { moment: from, rate } = this;
      this.sound.post({ kind: 'replay', events, from, rate }, [events.buffer]);
    } else {
      this.startedAt = this.heard();
    }
  }

  /** @param {number} rate 1 or less */
  setRate(rate) {
    const running = this.mode === 'replaying';
    if (running) this.pause();
    this.rate = rate;
    if (running) this.play();
  }

  /** From the start: a new scene, or a finished run. @param {boolean} finished */
  reset(finished) {
    this.offset = null;
    this.startedAt = null;
    this.moment = 0;
    this.finished = finished;
    this.playsWithSound = false;
    this.change(finished ? 'paused' : 'live');
  }

  /** @param {Mode} mode */
  change(mode) {
    this.mode = mode;
    this.dispatchEvent(new Event('change'));
  }
}
