// Drives the WebAssembly module as a page does, and writes what comes out as raw numbers.
//   node drive.mjs MODULE world SCENE END OUTPUT             f64: the impacts, fetched every 20 ms
//   node drive.mjs MODULE synth SCENE EVENTS FRAMES OUTPUT   f32: pressures, blocks of 128, left, right
//   node drive.mjs MODULE strike MODEL MATERIAL NUMBERS OUTPUT   f64: two events and the contact
//   node drive.mjs MODULE time SCENE END                     prints the processor time that the world took
import { readFileSync, writeFileSync } from 'node:fs';
import { CONTACT_STRIDE, EVENT_STRIDE } from '../../../../web/src/event-layout.js';

const [file, mode, sceneFile, ...rest] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(file), {});
const wasm = instance.exports;

function put(bytes) {
  // Whatever is called may move the memory: views are made after it.
  const at = wasm.buffer(bytes.length);
  new Uint8Array(wasm.memory.buffer, at, bytes.length).set(bytes);
  return bytes.length;
}

function done(status) {
  if (status >= 0) return status;
  const text = new Uint8Array(wasm.memory.buffer, wasm.message(), wasm.message_length());
  throw new Error(new TextDecoder().decode(text));
}

function* worldUntil(end) {
  done(wasm.world_load(put(readFileSync(sceneFile))));
  for (let k = 1; k <= Math.round(50 * end); k += 1) {
    while (done(wasm.world_advance(k / 50, 0)) === 1);
    yield k / 50;
    wasm.world_clear();
  }
}

if (mode === 'world') {
  const [end, output] = rest;
  const impacts = [];
  for (const _ of worldUntil(Number(end))) {
    const at = wasm.world_contacts();
    const length = CONTACT_STRIDE * wasm.world_contacts_count();
    impacts.push(...new Float64Array(wasm.memory.buffer, at, length));
  }
  writeFileSync(output, new Uint8Array(Float64Array.from(impacts).buffer));
} else if (mode === 'synth') {
  const [events, frames, output] = rest;
  const block = 128;
  done(wasm.synth_start(48000, block, put(readFileSync(sceneFile))));
  done(wasm.synth_listener(-0.1, 0.2, 0.5, 0.1, 0.2, 0.5));
  const bytes = readFileSync(events);
  put(bytes);
  const count = bytes.length / (EVENT_STRIDE * 8);
  if (wasm.synth_push(count) !== count) throw new Error('events were refused');
  const samples = [];
  for (let frame = 0; frame < Number(frames); frame += block) {
    // Behind the samples of the loudspeaker are the pressures.
    const at = wasm.synth_render(block) + 2 * 4 * block;
    samples.push(...new Float32Array(wasm.memory.buffer, at, 2 * block));
  }
  writeFileSync(output, new Uint8Array(Float32Array.from(samples).buffer));
} else if (mode === 'strike') {
  const [material, numbers, output] = rest;
  done(wasm.strike_load(0, put(readFileSync(sceneFile))));
  put(readFileSync(numbers));
  const count = done(wasm.strike_impact(0, Number(material)));
  const rows = new Float64Array(wasm.memory.buffer, wasm.strike_events(), count * EVENT_STRIDE);
  const contact = new Float64Array(wasm.memory.buffer, wasm.strike_contact(), CONTACT_STRIDE);
  writeFileSync(output, new Uint8Array(Float64Array.from([...rows, ...contact]).buffer));
} else {
  const [end] = rest;
  // Microseconds of this process.
  const clock = () => process.cpuUsage().user + process.cpuUsage().system;
  let [last, impacts] = [clock(), 0];
  for (const time of worldUntil(Number(end))) {
    impacts += wasm.world_contacts_count();
    if (Math.round(2 * time) === 2 * time) {
      const now = clock();
      const share = ((now - last) / 5e5).toFixed(3);
      console.log(`t ${time} s: ${impacts} impacts, ${share} s per second, solver ${wasm.world_solver()}`);
      [last, impacts] = [now, 0];
    }
  }
}
