// Records the sound at the ears in pascals and downloads it as a WAV file.

import { wavFile } from './wav-file.js';

/** Longest recording [s]: 400 kB per second are kept in memory until it is written. */
const LONGEST = 600;

export class Recorder {
  /** @param {import('./sound.js').Sound} sound */
  constructor(sound) {
    this.sound = sound;
    this.on = false;
    this.started = 0;
    sound.addEventListener('recorded', () => this.write());
  }

  /** Seconds so far. */
  get length() {
    return this.on ? (performance.now() - this.started) / 1000 : 0;
  }

  toggle() {
    this.on = !this.on;
    if (this.on) {
      this.started = performance.now();
      this.sound.recorded = [[], []];
    }
    this.sound.post({ kind: 'record', on: this.on });
  }

  /** Stops a recording that exceeds the limit. */
  watch() {
    if (this.length > LONGEST) this.toggle();
  }

  write() {
    const { context, recorded } = this.sound;
    if (!context) return;
    const file = wavFile(recorded[0], recorded[1], context.sampleRate);
    this.sound.recorded = [[], []];
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([file], { type: 'audio/wav' }));
    link.download = 'clangor-pascals.wav';
    link.click();
    URL.revokeObjectURL(link.href);
  }
}
