// Entry point of the page. Data flow from the scene to sound and picture:
//
//   preset ─► Stage ─► World (worker) ─ events ─► worklet (Sound) ─► ears
//                        └─ poses, contacts ─► History ─► Transport (which moment) ─► Picture, EventLog
//   tap ───► Stage ─► Strikes (forces) ─ events ─► worklet (Sound) ─ their time ─► Stage ─► History

import { Controls } from './controls.js';
import { EventLog } from './event-log.js';
import { Gestures } from './gestures.js';
import { History } from './history.js';
import { Keyboard } from './keyboard.js';
import { LevelMeter } from './level-meter.js';
import { Listeners } from './listeners.js';
import { reason, Refusal, sentence } from './messages.js';
import { Picture } from './picture.js';
import { PRESETS } from './presets.js';
import { Recorder } from './recorder.js';
import { Sound } from './sound.js';
import { Spectrogram } from './spectrogram.js';
import { Stage } from './stage.js';
import { Strikes } from './strike.js';
import { Transport } from './transport.js';
import { World } from './world.js';

/** Frames between two updates of the text and numbers. */
const FRAMES_PER_WORDS = 8;

/** @param {string} id */
const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

/** @param {string} text */
function complain(text) {
  const place = element('trouble');
  place.textContent = sentence(text);
  place.hidden = false;
  clearTimeout(complain.timer);
  complain.timer = setTimeout(() => (place.hidden = true), 8000);
}
/** @type {ReturnType<typeof setTimeout> | undefined} */
complain.timer = undefined;

async function loadModule() {
  try {
    return await WebAssembly.compileStreaming(fetch(new URL('clangor.wasm', document.baseURI)));
  } catch (error) {
    console.warn(error);
    throw new Refusal('clangor.wasm, which computes the sound, could not be loaded: reload the page');
  }
}

function openPicture() {
  try {
    return new Picture(/** @type {HTMLCanvasElement} */ (element('picture')), element('overlay'));
  } catch (error) {
    console.warn(error);
    throw new Refusal('this browser draws no pictures in three dimensions (WebGL 2), which the page needs');
  }
}

async function open() {
  // A gesture while the page is still loading counts.
  let tapped = false;
  for (const kind of ['pointerup', 'keydown']) addEventListener(kind, () => (tapped = true), { once: true });
  const module = await loadModule();
  const world = new World(module);
  const sound = new Sound(module);
  const history = new History();
  const transport = new Transport(world, sound, history);
  const stage = new Stage(world, sound, history, transport, new Strikes(module));
  const listeners = new Listeners();
  const recorder = new Recorder(sound);
  const picture = openPicture();
  const spectrogram = new Spectrogram(/** @type {HTMLCanvasElement} */ (element('spectrogram')));
  for (const { text, part } of Spectrogram.marks()) {
    const mark = document.createElement('span');
    mark.textContent = text;
    mark.style.top = `${100 * part}%`;
    element('spectrum').append(mark);
  }
  const meter = new LevelMeter(element('meter-bar'), element('level'), element('peak'));
  const log = new EventLog(element('log'));
  const controls = new Controls({ stage, sound, transport, listeners, picture, recorder, complain });
  new Gestures(picture.canvas, picture, listeners, controls.actions());
  new Keyboard(controls);

  for (const source of [world, sound, stage]) {
    source.addEventListener('failed', (event) => complain(/** @type {CustomEvent<string>} */ (event).detail));
  }
  world.addEventListener('bodies', () => {
    picture.setBodies(world, stage.preset.extent(stage.box));
    listeners.floorHeight = picture.planes.floorHeight;
  });
  stage.addEventListener('scene', () => {
    picture.look(stage.preset.view);
    picture.solids.setObjects(stage.objects);
    log.clear();
  });
  sound.addEventListener('report', (event) => {
    const report = /** @type {CustomEvent<import('./sound.js').Report>} */ (event).detail;
    meter.update(report);
    controls.report = report;
  });

  let frames = 0;
  const draw = () => {
    requestAnimationFrame(draw);
    if (!sound.on && !sound.starting && stage.movesUnheard) world.tick(performance.now() / 1000);
    const time = transport.shown();
    picture.draw(history, time, listeners);
    controls.followEars();
    if (sound.analyser && sound.on) spectrogram.draw(sound.analyser);
    frames += 1;
    if (frames % FRAMES_PER_WORDS === 0) {
      controls.followTime(time);
      recorder.watch();
      if (controls.logOpen) log.update(history, time, (body) => stage.nameOf(body));
    }
  };
  // For tests, and for users who open the console.
  Object.assign(globalThis, {
    clangor: { world, sound, history, transport, stage, listeners, picture, controls },
  });
  const wanted = PRESETS.find((preset) => preset.id === location.hash.slice(1));
  await controls.choose(wanted ?? PRESETS[0]);
  if (tapped) controls.wake(true);
  requestAnimationFrame(draw);
}

open().catch((error) =>
  complain(`The page could not start: ${reason(error, 'reload it, or try another browser')}`),
);
