// The latest contacts as text: time, bodies, speed, impulse and duration.

/** Rows kept. */
const ROWS = 40;

/** Largest number of rows added per frame. */
const ROWS_PER_UPDATE = 8;

/** Impacts of the page come at most this much after their time, when the machine is busy [s]. */
const LATEST = 2;

export class EventLog {
  /** @param {HTMLElement} list */
  constructor(list) {
    this.list = list;
    this.clear();
  }

  clear() {
    this.list.replaceChildren();
    this.shownUntil = -Infinity;
    /** @type {WeakSet<import('./history.js').Contact>} */
    this.shown = new WeakSet();
  }

  /**
   * @param {import('./history.js').History} history
   * @param {number} time audible world time [s]
   * @param {(body: number) => string} nameOf
   */
  update(history, time, nameOf) {
    if (time < this.shownUntil) this.clear();
    const since = this.shownUntil - LATEST;
    const fresh = history.contactsBetween(since, time).filter((contact) => !this.shown.has(contact));
    this.shownUntil = time;
    for (const contact of fresh) this.shown.add(contact);
    for (const contact of fresh.slice(-ROWS_PER_UPDATE)) {
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
