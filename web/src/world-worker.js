// The thread of the world: simulates slightly ahead of the audio clock, whose ticks come from the worklet. It
// sends events directly to the worklet, and poses and contacts to the page. It uses no timers, because
// browsers throttle the timers of hidden tabs.

import { WorldClock } from './clock.js';
import { addSphere } from './add-sphere.js';
import {
  BODY_STRIDE,
  CONTACT_STRIDE,
  EVENT,
  EVENT_STRIDE,
  LINK_STRIDE,
  POSE_STRIDE,
} from './event-layout.js';
import { shiftTimes } from './shift-times.js';
import { Rain } from './rain.js';
import { WasmInstance } from './wasm-instance.js';

/** Least interval between two poses sent to the page [s]. */
const POSE_INTERVAL = 1 / 75;

/** Longest computation per tick [s]; the next tick continues it. */
const TICK_BUDGET = 0.012;

/** Places tried for a new ball, each a diameter above the last. */
const PLACES = 12;

const clock = new WorldClock();

/** @type {WebAssembly.Module} */
let module;
/** @type {WasmInstance} */
let world;
/** @type {MessagePort | null} */
let worklet = null;
let generation = 0;
let running = false;
/** Source of the clock: the sound, or the page while there is no sound.
 * @type {'page' | 'sound'} */
let driver = 'page';
let lastPoseTime = -Infinity;
/** @type {Rain | null} */
let rain = null;
/** Contacts and events since the last frame sent to the page, in world time.
 * @type {Float64Array[]} */
let contacts = [];
/** @type {Float64Array[]} */
let events = [];

/** @param {Record<string, any>} message @param {Transferable[]} [transfer] */
function tell(message, transfer = []) {
  postMessage({ generation, ...message }, { transfer });
}

function describeBodies() {
  const { exports } = world;
  const bodies = world.readNumbers(exports.world_bodies(), exports.world_body_count() * BODY_STRIDE);
  const links = world.readNumbers(exports.world_links(), exports.world_link_count() * LINK_STRIDE);
  tell({ kind: 'bodies', bodies, links }, [bodies.buffer, links.buffer]);
}

/** @param {{ text: string, generation: number, rain: import('./rain.js').RainSettings | null }} message */
function load(message) {
  generation = message.generation;
  running = false;
  clock.stop();
  contacts = [];
  events = [];
  lastPoseTime = -Infinity;
  // A new instance, independent of failures of the last one.
  world = new WasmInstance(module);
  world.check(world.exports.world_load(world.writeBytes(new TextEncoder().encode(message.text))));
  world.check(world.exports.world_materials());
  const materials = JSON.parse(world.message());
  rain = message.rain && new Rain(message.rain);
  tell({ kind: 'loaded', materials, solver: world.exports.world_solver() });
  describeBodies();
  sendFrame();
  running = true;
}

/** Simulates up to the time that the sound needs next.
 * @param {number} soundTime [s] @param {'page' | 'sound'} from */
function tick(soundTime, from) {
  if (!running) return;
  if (from !== driver) clock.stop();
  driver = from;
  const { exports } = world;
  const until = clock.due(soundTime, exports.world_time());
  const start = performance.now();
  let added = false;
  if (rain) added = rain.fall(world);
  let status;
  do {
    status = exports.world_advance(until, TICK_BUDGET);
    world.check(status);
  } while (status === 1 && performance.now() - start < TICK_BUDGET * 1000);
  collect();
  if (added) describeBodies();
  if (exports.world_time() - lastPoseTime >= POSE_INTERVAL) sendFrame();
}

function collect() {
  const { exports } = world;
  const count = exports.world_events_count();
  const contactCount = exports.world_contacts_count();
  if (contactCount > 0) {
    contacts.push(world.readNumbers(exports.world_contacts(), contactCount * CONTACT_STRIDE));
  }
  if (count > 0) {
    const happened = world.readNumbers(exports.world_events(), count * EVENT_STRIDE);
    events.push(happened);
    if (worklet && driver === 'sound') {
      const sounding = happened.slice();
      shiftTimes(sounding, EVENT_STRIDE, EVENT.time, clock.offset);
      worklet.postMessage({ kind: 'events', events: sounding }, [sounding.buffer]);
    }
  }
  if (count > 0 || contactCount > 0) exports.world_clear();
}

function sendFrame() {
  const { exports } = world;
  const time = exports.world_time();
  lastPoseTime = time;
  const poses = world.readFloats(exports.world_poses(), exports.world_body_count() * POSE_STRIDE);
  const frame = {
    kind: 'frame',
    time,
    offset: clock.offset,
    driver,
    skips: clock.skips,
    poses,
    contacts: join(contacts),
    events: join(events),
  };
  contacts = [];
  events = [];
  tell(frame, [poses.buffer, frame.contacts.buffer, frame.events.buffer]);
}

/** @param {Float64Array[]} parts */
function join(parts) {
  const whole = new Float64Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    whole.set(part, at);
    at += part.length;
  }
  return whole;
}

/** Handlers of the page's messages by kind.
 * @type {Record<string, (message: any) => void>} */
const answers = {
  start(message) {
    module = message.module;
  },
  load,
  connect({ port, sampleRate }) {
    worklet = port;
    clock.sampleRate = sampleRate;
    port.onmessage = (/** @type {MessageEvent} */ message) => guard(() => tick(message.data.time, 'sound'));
  },
  tick({ time }) {
    tick(time, 'page');
  },
  run({ on }) {
    running = on;
    clock.stop();
  },
  throw({ body, velocity }) {
    world.check(world.exports.world_set_velocity(body, ...velocity));
  },
  add({ material, radius, position, velocity }) {
    // Where another ball is, the new one goes on top.
    const [x, y, z] = position;
    const add = (/** @type {number} */ place) =>
      addSphere(world, material, radius, [x, y + 2 * radius * place, z], velocity);
    let place = 0;
    while (place < PLACES && add(place) < 0) place += 1;
    // The message is that of the place asked for.
    if (place === PLACES) world.check(add(0));
    describeBodies();
  },
  gravity({ vector }) {
    world.check(world.exports.world_gravity(...vector));
  },
  rain({ settings }) {
    rain = settings && new Rain(settings);
  },
};

/** Runs an action and reports its failure to the page; the next message is handled as usual.
 * @param {() => void} action */
function guard(action) {
  try {
    action();
  } catch (error) {
    tell({ kind: 'failed', message: String(error instanceof Error ? error.message : error) });
  }
}

addEventListener('message', (/** @type {MessageEvent} */ message) => {
  const answer = answers[message.data.kind];
  if (answer) guard(() => answer(message.data));
});
