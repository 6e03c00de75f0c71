// Level meter in real units: sound pressure level re 20 µPa at the ears, and the peak in pascals.

/** Reference pressure of sound in air [Pa]. */
const REFERENCE = 20e-6;

/** Ends of the bar [dB SPL]. */
const LOW = 20;
const HIGH = 120;

/** Decay rate of the bar [dB/s]. */
const FALL = 30;

/** Hold time of the peak value [s]. */
const HOLD = 1.5;

export class LevelMeter {
  /**
   * @param {HTMLElement} bar gets its filled part as `--level`
   * @param {HTMLElement} level for the number in dB
   * @param {HTMLElement} peak for the number in pascals
   */
  constructor(bar, level, peak) {
    this.bar = bar;
    this.level = level;
    this.peak = peak;
    this.shown = LOW;
    this.held = 0;
    this.heldSince = 0;
    this.lastTime = 0;
  }

  /** @param {import('./sound.js').Report} report */
  update(report) {
    const measured = 20 * Math.log10(Math.max(report.rootMeanSquare, 1e-9) / REFERENCE);
    const passed = Math.max(0, report.time - this.lastTime);
    this.lastTime = report.time;
    this.shown = Math.max(measured, this.shown - FALL * passed, LOW);
    if (report.peak >= this.held || report.time > this.heldSince + HOLD) {
      this.held = report.peak;
      this.heldSince = report.time;
    }
    const part = Math.min(1, (this.shown - LOW) / (HIGH - LOW));
    this.bar.style.setProperty('--level', part.toFixed(3));
    this.level.textContent = this.shown > LOW ? `${this.shown.toFixed(0)} dB` : '– dB';
    this.peak.textContent = `${pascals(this.held)} peak`;
  }
}

/** A pressure with a fitting unit. @param {number} value [Pa] */
export function pascals(value) {
  if (value >= 1) return `${value.toFixed(value >= 10 ? 0 : 1)} Pa`;
  if (value >= 1e-3) return `${(value * 1e3).toFixed(value >= 0.01 ? 0 : 1)} mPa`;
  return `${(value * 1e6).toFixed(0)} µPa`;
}
