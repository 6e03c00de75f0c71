// The latest contacts as text: time, bodies, speed, impulse and duration.

/** Rows kept. */
const ROWS = 40;

/** Largest number of rows added per frame. */
const ROWS_PER_UPDATE = 8;

export class EventLog {
  /** @param {HTMLElement} list */
  constructor(list) {
    this.list = list;
    this.shownUntil = 0;
  }

  clear() {
    this.list.replaceChildren();
    this.shownUntil = 0;
  }

  /**
   * @param {import('./history.js').History} history
   * @param {number} time audible world time [s]
   * @param {(body: number) => string} nameOf
   */
  update(history, time, nameOf) {
    if (time < this.shownUntil) this.clear();
    const latest = history.contactsBetween(this.shownUntil, time).slice(-ROWS_PER_UPDATE);
    this.shownUntil = time;
    for (const contact of latest) {
      const row = document.createElement('li');
      const pair = [contact.bodyA, contact.bodyB].filter((body) => body !== -1).map(nameOf);
      for (const [kind, text] of [
        ['time', `${contact.time.toFixed(3)} s`],
        ['pair', pair.join(' · ')],
        ['speed', `${contact.speed.toFixed(2)} m/s`],
        ['impulse', impulse(contact.impulse)],
        ['duration', duration(contact.duration)],
      ]) {
        const cell = document.createElement('span');
        cell.className = kind;
        cell.textContent = text;
        row.append(cell);
      }
      this.list.prepend(row);
    }
    while (this.list.childElementCount > ROWS) this.list.lastElementChild?.remove();
  }
}

/** @param {number} value [N s] */
function impulse(value) {
  if (value >= 0.1) return `${value.toFixed(2)} N s`;
  return `${(value * 1e3).toFixed(value >= 1e-3 ? 1 : 3)} mN s`;
}

/** @param {number} value [s] */
function duration(value) {
  if (!(value > 0)) return '';
  return value >= 1e-3 ? `${(value * 1e3).toFixed(1)} ms` : `${(value * 1e6).toFixed(0)} µs`;
}
