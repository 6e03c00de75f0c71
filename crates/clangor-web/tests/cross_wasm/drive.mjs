// Drives the WebAssembly module as a page does, and writes what comes out as raw numbers.
//   node drive.mjs MODULE world SCENE END OUTPUT             f64: the impacts, fetched every 20 ms
//   node drive.mjs MODULE synth SCENE EVENTS FRAMES OUTPUT   f32: blocks of 128 frames, left then right
//   node drive.mjs MODULE time SCENE END                     prints the time that the world took
import { readFileSync, writeFileSync } from 'node:fs';

const [file, mode, sceneFile, ...rest] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(file), {});
const wasm = instance.exports;

function put(bytes) {
  new Uint8Array(wasm.memory.buffer, wasm.buffer(bytes.length), bytes.length).set(bytes);
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
    impacts.push(...new Float64Array(wasm.memory.buffer, wasm.world_contacts(), 12 * wasm.world_contacts_count()));
  }
  writeFileSync(output, new Uint8Array(Float64Array.from(impacts).buffer));
} else if (mode === 'synth') {
  const [events, frames, output] = rest;
  const block = 128;
  done(wasm.synth_start(48000, block, put(readFileSync(sceneFile))));
  done(wasm.synth_listener(-0.1, 0.2, 0.5, 0.1, 0.2, 0.5));
  const bytes = readFileSync(events);
  put(bytes);
  const count = bytes.length / (24 * 8);
  if (wasm.synth_push(count) !== count) throw new Error('events were refused');
  const samples = [];
  for (let frame = 0; frame < Number(frames); frame += block) {
    samples.push(...new Float32Array(wasm.memory.buffer, wasm.synth_render(block), 2 * block));
  }
  writeFileSync(output, new Uint8Array(Float32Array.from(samples).buffer));
} else {
  const [end] = rest;
  let [last, impacts] = [performance.now(), 0];
  for (const time of worldUntil(Number(end))) {
    impacts += wasm.world_contacts_count();
    if (Math.round(2 * time) === 2 * time) {
      const now = performance.now();
      const share = ((now - last) / 500).toFixed(3);
      console.log(`t ${time} s: ${impacts} impacts, ${share} s per second, solver ${wasm.world_solver()}`);
      [last, impacts] = [now, 0];
    }
  }
}
