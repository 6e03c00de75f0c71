// Buttons, sliders and lists: their actions and displays.

import { radioButtons, selection, showChosen } from './choices.js';
import { KEPT } from './history.js';
import { pascals } from './level-meter.js';
import { readRun } from './exported-run.js';
import { reason } from './messages.js';
import { presetOfRun, PRESETS } from './presets.js';
import { BALL_MATERIALS, COUNTS, WALL_MATERIALS } from './sphere-box.js';
import { MALLETS } from './strike.js';

/** Replay rates. */
const RATES = { 1: '1×', 0.5: '½', 0.25: '¼', 0.1: '⅒' };

/** Smaller windows begin with the settings closed [em of the reader's letters]. */
const SMALL = '(width <= 48em) or (height <= 34em)';

/** Pressure at full scale and its level re 20 µPa. @param {number} value [Pa] */
const fullScaleText = (value) => `${pascals(value)} · ${(20 * Math.log10(value / 20e-6)).toFixed(0)} dB`;

/** @param {string} id @returns {any} the element */
const element = (id) => document.getElementById(id);

export class Controls {
  /**
   * @param {object} parts
   * @param {import('./stage.js').Stage} parts.stage
   * @param {import('./sound.js').Sound} parts.sound
   * @param {import('./transport.js').Transport} parts.transport
   * @param {import('./listeners.js').Listeners} parts.listeners
   * @param {import('./picture.js').Picture} parts.picture
   * @param {import('./recorder.js').Recorder} parts.recorder
   * @param {(text: string) => void} parts.complain
   */
  constructor({ stage, sound, transport, listeners, picture, recorder, complain }) {
    this.stage = stage;
    this.sound = sound;
    this.transport = transport;
    this.listeners = listeners;
    this.picture = picture;
    this.recorder = recorder;
    this.complain = complain;
    /** @type {import('./sound.js').Report | null} */
    this.report = null;
    this.lastEars = '';
    this.roomOn = false;
    /** Whether the present gesture turns the sound on. */
    this.waking = false;
    /** Whether the page answers the first gesture itself, where that gesture did nothing that is heard. */
    this.answers = false;
    this.bindScene();
    this.bindBalls();
    this.bindListening();
    this.bindTransport();
    for (const kind of ['pointerdown', 'keydown']) {
      addEventListener(kind, () => (this.waking = false), { capture: true });
    }
    for (const kind of ['pointerdown', 'pointerup', 'click', 'keydown']) {
      addEventListener(kind, () => this.wake(), { capture: true });
    }
    for (const [source, kind] of [
      [sound, 'on'],
      [stage, 'scene'],
    ]) {
      /** @type {EventTarget} */ (source).addEventListener(/** @type {string} */ (kind), () => this.answer());
    }
    // A clicked button loses the focus, so that the space bar pauses and does not press the button again.
    addEventListener('click', (event) => {
      const target = /** @type {HTMLElement} */ (event.target);
      if (event.detail > 0 && target.closest('button, label') && !target.closest('dialog')) {
        picture.canvas.focus({ preventScroll: true });
      }
    });
    if (matchMedia(SMALL).matches) this.showSettings(false);
    new ResizeObserver(() => this.leaveRoom()).observe(element('free'));
    this.leaveRoom();
    this.showSound();
  }

  /** Tells the picture which part of the window is free. */
  leaveRoom() {
    const free = element('free').getBoundingClientRect();
    this.picture.cover({
      top: free.top,
      right: innerWidth - free.right,
      bottom: innerHeight - free.bottom,
      left: free.left,
    });
    for (const group of ['presets', 'rate']) showChosen(element(group));
  }

  bindScene() {
    const names = PRESETS.map(({ id, name }) => /** @type {[string, string]} */ ([id, name]));
    this.markPreset = radioButtons(element('presets'), names, PRESETS[0].id, (id) => {
      const preset = PRESETS.find((candidate) => candidate.id === id);
      if (preset) this.choose(preset);
    });
    element('drop').addEventListener('click', () => this.drop());
    element('throw').addEventListener('click', () => this.throwSomething());
    element('strike').addEventListener('click', () => this.strikeSomething());
    element('again').addEventListener('click', () => this.again());
    element('gravity').addEventListener('click', () => this.toggleGravity());
    element('settings-toggle').addEventListener('click', () => {
      this.showSettings(element('settings').hidden);
    });
    element('help-open').addEventListener('click', () => this.explain());
    const file = element('run-file');
    element('open-run').addEventListener('click', () => file.click());
    file.addEventListener('change', () => this.openRun(file.files[0]));
    addEventListener('dragover', (event) => event.preventDefault());
    addEventListener('drop', (event) => {
      event.preventDefault();
      this.openRun(event.dataTransfer?.files[0]);
    });
  }

  bindBalls() {
    const { stage } = this;
    selection(element('material'), BALL_MATERIALS, 'steel', (value) => {
      const material = /** @type {keyof typeof BALL_MATERIALS} */ (value);
      if (stage.preset.id === 'box') {
        stage.box.material = material;
        this.again();
      }
      if (material !== 'mixed') stage.drop.material = material;
    });
    selection(element('walls'), WALL_MATERIALS, stage.box.walls, (value) => {
      stage.box.walls = /** @type {keyof typeof WALL_MATERIALS} */ (value);
      this.again();
    });
    element('radius').addEventListener('input', () => {
      stage.drop.radius = element('radius').valueAsNumber / 1000;
      this.showBalls();
    });
    element('count').addEventListener('input', () => {
      stage.box.count = COUNTS[element('count').valueAsNumber];
      this.showBalls();
    });
    for (const id of ['radius', 'count']) {
      element(id).addEventListener('change', () => {
        if (stage.preset.id !== 'box') return;
        stage.box.radius = stage.drop.radius;
        this.again();
      });
    }
    const mallets = Object.entries(MALLETS).map(
      ([id, { name }]) => /** @type {[string, string]} */ ([id, name]),
    );
    radioButtons(element('mallet'), mallets, stage.mallet, (value) => {
      stage.mallet = /** @type {keyof typeof MALLETS} */ (value);
    });
    const speed = element('strike-speed');
    const showSpeed = () => {
      stage.strikeSpeed = 10 ** speed.valueAsNumber;
      element('strike-speed-value').textContent = `${stage.strikeSpeed.toPrecision(2)} m/s`;
    };
    speed.value = Math.log10(stage.strikeSpeed);
    speed.addEventListener('input', showSpeed);
    showSpeed();
  }

  bindListening() {
    const places = ['1', '2', '3', '4'].map(
      (name, index) => /** @type {[string, string]} */ ([String(index), name]),
    );
    this.markListener = radioButtons(element('listener'), [...places, ['view', 'My view']], '0', (value) =>
      this.listenFrom(value),
    );
    element('listener-here').addEventListener('click', () => this.earsToView());
    element('room').addEventListener('click', () => this.toggleRoom());
    element('sound').addEventListener('click', () => this.toggleSound());
    element('record').addEventListener('click', () => {
      if (!this.sound.on) {
        this.complain('There is nothing to record yet: turn the sound on.');
        return;
      }
      this.recorder.toggle();
      element('record').setAttribute('aria-pressed', String(this.recorder.on));
    });
    element('full-scale').addEventListener('input', () => {
      this.setFullScale(10 ** element('full-scale').valueAsNumber);
    });
    for (const kind of ['on', 'state']) this.sound.addEventListener(kind, () => this.showSound());
  }

  bindTransport() {
    const { transport } = this;
    element('play').addEventListener('click', () => this.playOrPause());
    element('live').addEventListener('click', () => this.goLive());
    const scrub = element('scrub');
    scrub.addEventListener('input', () => {
      transport.pauseAt(transport.history.end + scrub.valueAsNumber);
    });
    radioButtons(element('rate'), Object.entries(RATES), '1', (value) => {
      transport.setRate(Number(value));
    });
    transport.addEventListener('change', () => {
      const standing = transport.mode === 'paused';
      element('transport').dataset.mode = transport.mode;
      element('play').dataset.running = String(!standing);
      element('play-name').textContent = standing ? 'Replay' : 'Pause';
      element('live').setAttribute('aria-pressed', String(transport.mode === 'live'));
    });
    element('play').dataset.running = 'true';
    element('transport').dataset.mode = transport.mode;
  }

  /** @param {import('./presets.js').Preset} preset */
  async choose(preset) {
    this.markPreset(preset.id);
    showChosen(element('presets'));
    history.replaceState(null, '', `#${preset.id}`);
    for (const id of ['story', 'story-in-settings']) element(id).textContent = preset.story;
    element('how').textContent = preset.how;
    const strikes = preset.objects !== undefined;
    document.body.dataset.finished = String(preset.run !== undefined);
    document.body.dataset.strikes = String(strikes);
    element('strike-settings').hidden = !strikes;
    const box = preset.id === 'box';
    for (const field of document.querySelectorAll('[data-only="box"]')) {
      /** @type {HTMLElement} */ (field).hidden = !box;
    }
    element('ball-title').textContent = box ? 'Balls in the box' : 'The next ball';
    this.listeners.set(preset.ears, preset.view.target);
    this.markListener('0');
    this.listeners.followsCamera = false;
    this.setFullScale(preset.fullScale);
    this.setRoom(preset.room === true);
    try {
      await this.stage.load(preset);
    } catch (error) {
      this.complain(reason(error, 'the scene could not be loaded: reload the page'));
    }
    if (box) this.stage.drop.radius = this.stage.box.radius;
    this.showBalls();
    this.showGravity();
  }

  /** @param {File | undefined} file written by `clangor export web` */
  async openRun(file) {
    if (!file) return;
    element('help').close();
    try {
      const run = readRun(new Uint8Array(await file.arrayBuffer()));
      await this.choose(presetOfRun(run, file.name));
    } catch (error) {
      this.complain(`${file.name}: ${reason(error, 'the file is damaged')}`);
    }
  }

  showBalls() {
    const { stage } = this;
    const box = stage.preset.id === 'box';
    element('radius').value = stage.drop.radius * 1000;
    element('radius-value').textContent = `${(stage.drop.radius * 1000).toFixed(0)} mm`;
    element('count').value = COUNTS.indexOf(stage.box.count);
    element('count-value').textContent = String(stage.box.count);
    const own = element('own-material');
    const listed = stage.preset.drop.material in BALL_MATERIALS;
    own.hidden = listed;
    own.value = own.textContent = listed ? '' : stage.preset.drop.material;
    element('material').value = box ? stage.box.material : stage.drop.material;
    element('material').querySelector('[value="mixed"]').hidden = !box;
  }

  /** @param {boolean} shown */
  showSettings(shown) {
    element('settings').hidden = !shown;
    element('settings-toggle').setAttribute('aria-expanded', String(shown));
    this.leaveRoom();
  }

  showGravity() {
    element('gravity').setAttribute('aria-pressed', String(this.stage.gravityOn));
  }

  showSound() {
    const on = this.sound.on && !this.sound.muted;
    element('sound').setAttribute('aria-pressed', String(on));
    element('wake').hidden = this.sound.on;
  }

  /**
   * Turns the sound on; browsers require a gesture.
   * @param {boolean} allowed whether the browser takes the present event for one
   */
  wake(allowed = navigator.userActivation?.isActive !== false) {
    if (this.sound.on || !allowed) return;
    this.waking = true;
    if (!this.sound.starting) this.answers = true;
    this.sound
      .start((port, sampleRate) => this.stage.world.connect(port, sampleRate))
      .then(() => this.showSound())
      .catch((error) => this.complain(`There is no sound: ${reason(error, 'the browser cannot play it')}`));
  }

  /** What is heard after the first gesture, where neither that gesture nor the scene makes a sound. */
  answer() {
    const { sound, stage } = this;
    if (!this.answers || !sound.on || !stage.ready) return;
    this.answers = false;
    const still = stage.objects.length > 0 || stage.preset.rain !== undefined;
    if (still && stage.actions === 0) this.drop();
  }

  toggleSound() {
    // The gesture that turns the sound on does not mute it.
    if (this.sound.on && !this.waking) this.sound.mute(!this.sound.muted);
    this.showSound();
  }

  drop() {
    this.stage.dropSomewhere();
  }

  throwSomething() {
    this.stage.throwSomething();
  }

  strikeSomething() {
    this.stage.strikeSomething();
  }

  again() {
    this.stage
      .again()
      .catch((error) => this.complain(reason(error, 'the scene could not be loaded: reload the page')));
  }

  toggleGravity() {
    this.stage.gravity(!this.stage.gravityOn);
    this.showGravity();
  }

  toggleRoom() {
    this.setRoom(!this.roomOn);
  }

  /** @param {boolean} on */
  setRoom(on) {
    this.roomOn = on;
    this.sound.reflections(on);
    element('room').setAttribute('aria-pressed', String(on));
  }

  /** @param {number} value pressure at full scale [Pa] */
  setFullScale(value) {
    this.sound.gain(value);
    element('full-scale').value = Math.log10(value);
    element('full-scale-value').textContent = fullScaleText(value);
  }

  /** @param {string} value index of a listener, or 'view' */
  listenFrom(value) {
    this.listeners.followsCamera = value === 'view';
    if (value !== 'view') this.listeners.active = Number(value);
    this.markListener(value);
  }

  earsToView() {
    const { listeners } = this;
    listeners.move(listeners.active, this.picture.view.camera.position.clone());
    this.listenFrom(String(listeners.active));
  }

  playOrPause() {
    if (this.transport.mode === 'paused') this.transport.play();
    else this.transport.pause();
  }

  goLive() {
    this.transport.goLive();
  }

  explain() {
    element('help').showModal();
  }

  get logOpen() {
    return element('log-details').open;
  }

  /** Sends the ear positions to the sound if they have changed. */
  followEars() {
    if (this.listeners.places.length === 0) return;
    const ears = this.listeners.ears(this.picture.view);
    const now = [...ears.left, ...ears.right].map((x) => x.toFixed(4)).join();
    if (now === this.lastEars) return;
    this.lastEars = now;
    this.sound.listener(ears);
  }

  /** @param {number} time audible world time [s] */
  followTime(time) {
    const { transport } = this;
    const { start, end } = transport.history;
    const before = Math.min(0, time - end);
    const scrub = element('scrub');
    // Of a length even at the beginning, so that its knob is at the end.
    scrub.min = Math.min(-0.1, Math.max(-KEPT, start - end)).toFixed(2);
    const live = transport.mode === 'live';
    if (document.activeElement !== scrub || transport.mode !== 'paused') {
      scrub.value = live ? 0 : before;
    }
    element('moment').textContent = live ? 'live' : `${before.toFixed(2)} s`;
    if (this.recorder.on) {
      element('record-time').textContent = `${this.recorder.length.toFixed(0)} s`;
    }
    this.showFigures();
  }

  showFigures() {
    if (!this.report) return;
    const { load, synth } = this.report;
    const count = this.picture.balls.bodyOf.length;
    element('figures').textContent =
      `${count} balls · ${synth[8]} modes vibrating · audio thread ${(100 * load).toFixed(0)} % busy`;
  }

  /** Actions of pointers on the picture. @returns {import('./gestures.js').Actions} */
  actions() {
    const { stage, listeners, picture } = this;
    const hint = element('hint-at-pointer');
    return {
      listenFrom: (index) => this.listenFrom(String(index)),
      throwBall: (body, velocity) => stage.throwBall(body, velocity.toArray()),
      drop: (place) => stage.dropAt(place.toArray()),
      strike: ({ object, point }) => stage.strike(object, point),
      moveListener: (index, place) => {
        listeners.move(index, place);
        this.listenFrom(String(index));
      },
      // A drag across the whole scene gives the speed of a fall of three times its size.
      throwRate: () => Math.sqrt(60 / picture.scale) * 1.2,
      tell: (text, x, y) => {
        hint.textContent = text;
        hint.style.transform = `translate(${x}px, ${y}px)`;
      },
    };
  }
}
