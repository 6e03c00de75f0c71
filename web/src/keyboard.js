// Keyboard shortcuts of the page, except while the focus is on a text field, slider or list.

/** Rotation [rad] and factor of distance per key press. */
const TURN = 0.09;
const STEP = 1.12;

export class Keyboard {
  /** @param {import('./controls.js').Controls} controls */
  constructor(controls) {
    const { view } = controls.picture;
    /** @type {Record<string, () => void>} */
    this.keys = {
      d: () => controls.drop(),
      t: () => controls.throwSomething(),
      s: () => controls.strikeSomething(),
      n: () => controls.again(),
      g: () => controls.toggleGravity(),
      r: () => controls.toggleRoom(),
      m: () => controls.toggleSound(),
      l: () => controls.earsToView(),
      1: () => controls.listenFrom('0'),
      2: () => controls.listenFrom('1'),
      3: () => controls.listenFrom('2'),
      4: () => controls.listenFrom('3'),
      ' ': () => controls.playOrPause(),
      Escape: () => controls.goLive(),
      ArrowLeft: () => view.orbit(TURN, 0),
      ArrowRight: () => view.orbit(-TURN, 0),
      ArrowUp: () => view.orbit(0, TURN),
      ArrowDown: () => view.orbit(0, -TURN),
      '+': () => view.zoom(1 / STEP),
      '=': () => view.zoom(1 / STEP),
      '-': () => view.zoom(STEP),
      '?': () => controls.explain(),
    };
    addEventListener('keydown', (event) => this.press(event, controls));
  }

  /** @param {KeyboardEvent} event @param {import('./controls.js').Controls} controls */
  press(event, controls) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = /** @type {HTMLElement} */ (event.target);
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    // Buttons, sliders and lists keep their own keys.
    const own = target.closest('button, summary') ? [' '] : [];
    if (target.closest('input, select, dialog')) {
      own.push(' ', 'ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'Escape');
    }
    if (target.closest('select, dialog') || own.includes(key)) return;
    const action = this.keys[key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
