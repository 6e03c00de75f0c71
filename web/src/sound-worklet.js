// The audio thread: gives events to the synthesis when they are due, plays its samples, and sends the
// time to the page and the world. All times are those of the AudioContext; the synthesis counts from its
// own start.

import { EVENT, EVENT_STRIDE, REPORT_STRIDE } from './event-layout.js';
import { EventQueue } from './event-queue.js';
import { takeForceRows } from './force-rows.js';
import { ReplayFeeder } from './replay-feeder.js';
import { WasmInstance } from './wasm-instance.js';

/** Time by which events are given to the synthesis in advance [s]. */
const HORIZON = 0.03;

/** Events waiting for their time, at most. */
const QUEUE_CAPACITY = 32768;

/** Largest number of events given to the synthesis per block; the others follow in the next block. */
const EVENTS_PER_BLOCK = 256;

/** Blocks between two ticks: 10.7 ms at 48 kHz. */
const BLOCKS_PER_TICK = 4;

/** Blocks between two reports of level and load: 43 ms at 48 kHz. */
const BLOCKS_PER_REPORT = 16;

/** Threshold of the first sound in the latency measurement: −140 dB re full scale. */
const AUDIBLE = 1e-7;

/** Frames per message of a recording. */
const RECORDING_CHUNK = 4096;

class SoundProcessor extends AudioWorkletProcessor {
  /** @param {{ processorOptions: any }} options */
  constructor({ processorOptions }) {
    super();
    this.synth = new WasmInstance(processorOptions.module);
    this.queue = new EventQueue(QUEUE_CAPACITY);
    this.replay = new ReplayFeeder();
    this.batch = new Float64Array(EVENTS_PER_BLOCK * EVENT_STRIDE);
    /** @type {MessagePort | null} */
    this.worldPort = null;
    /** Frames rendered since the start of the scene: the clock of the synthesis. */
    this.rendered = 0;
    /** @type {number[] | null} */
    this.ears = null;
    this.reflections = true;
    this.blocks = 0;
    this.squares = 0;
    this.peak = 0;
    this.busy = 0;
    this.failures = 0;
    /** @type {{ left: Float32Array, right: Float32Array, filled: number } | null} */
    this.recording = null;
    /** Frame of the first sound after a request, for the measurement of latency; −1 while waiting. */
    this.firstSound = null;
    this.port.onmessage = (message) => this.answer(message.data);
    for (const message of processorOptions.messages ?? []) this.answer(message);
  }

  /** @param {any} message */
  answer(message) {
    const { exports } = this.synth;
    try {
      switch (message.kind) {
        case 'scene':
          this.queue.clear();
          this.replay.stop();
          // The text comes as bytes: there is no TextEncoder here.
          this.synth.check(exports.synth_start(sampleRate, 128, this.synth.writeBytes(message.bytes)));
          this.rendered = 0;
          // The start sets the receivers and reflections of the scene.
          if (this.ears) exports.synth_listener(...this.ears);
          exports.synth_reflections(this.reflections ? 1 : 0);
          this.port.postMessage({ kind: 'started', latency: exports.synth_latency() });
          break;
        case 'load': {
          const length = this.synth.writeBytes(message.bytes) - message.dampingLength;
          this.synth.check(exports.synth_load(message.slot, length, message.dampingLength));
          break;
        }
        case 'world':
          this.worldPort = message.port;
          message.port.onmessage = (/** @type {MessageEvent} */ event) => {
            if (event.data.kind === 'events') this.receive(event.data.events);
          };
          break;
        case 'events':
          this.receive(message.events);
          break;
        // Impacts of the page start as soon as possible; the page receives their time.
        case 'strike': {
          const { id, events } = message;
          for (let at = EVENT.time; at < events.length; at += EVENT_STRIDE) {
            events[at] = currentTime;
          }
          this.receive(events);
          this.port.postMessage({ kind: 'impacts', id, events });
          break;
        }
        case 'listener':
          this.listen([...message.left, ...message.right]);
          break;
        case 'gain':
          this.synth.check(exports.synth_gain(message.pascals));
          break;
        case 'reflections':
          this.reflections = message.on;
          exports.synth_reflections(message.on ? 1 : 0);
          break;
        case 'silence':
          this.queue.clear();
          this.replay.stop();
          exports.synth_silence();
          break;
        case 'replay':
          this.queue.clear();
          exports.synth_silence();
          this.giveForces(message.events);
          this.replay.start(message.events, message.from, message.rate, currentTime + HORIZON, sampleRate);
          this.port.postMessage({
            kind: 'replaying',
            from: message.from,
            rate: message.rate,
            at: this.replay.soundTime,
          });
          break;
        case 'record':
          this.record(message.on);
          break;
        case 'await-sound':
          this.firstSound = -1;
          break;
      }
    } catch (error) {
      this.complain(error);
    }
  }

  /** @param {Float64Array} events rows on the clock of the context */
  receive(events) {
    this.giveForces(events);
    this.queue.add(events);
  }

  /** Gives force histories to the synthesis before their impacts. @param {Float64Array} rows of events */
  giveForces(rows) {
    takeForceRows(rows, (part, count) => {
      this.synth.writeNumbers(part);
      this.synth.exports.synth_push(count);
    });
  }

  /** @param {number[]} ears left and right [m] */
  listen(ears) {
    if (!ears.every(Number.isFinite))
      throw new RangeError('the positions of the ears must be finite numbers');
    this.ears = ears;
    this.synth.exports.synth_listener(...ears);
  }

  /** @param {unknown} error */
  complain(error) {
    this.failures += 1;
    this.port.postMessage({
      kind: 'failed',
      message: String(error instanceof Error ? error.message : error),
    });
  }

  /** @param {boolean} on */
  record(on) {
    if (on) {
      this.recording = {
        left: new Float32Array(RECORDING_CHUNK),
        right: new Float32Array(RECORDING_CHUNK),
        filled: 0,
      };
    } else if (this.recording) {
      this.sendRecording(this.recording);
      this.recording = null;
      this.port.postMessage({ kind: 'recorded' });
    }
  }

  /** @param {{ left: Float32Array, right: Float32Array, filled: number }} recording */
  sendRecording(recording) {
    const left = recording.left.slice(0, recording.filled);
    const right = recording.right.slice(0, recording.filled);
    recording.filled = 0;
    this.port.postMessage({ kind: 'recording', left, right }, [left.buffer, right.buffer]);
  }

  /**
   * @param {Float32Array[][]} _inputs
   * @param {Float32Array[][]} outputs
   */
  process(_inputs, outputs) {
    const begun = Date.now();
    const [left, right] = outputs[0];
    const frames = left.length;
    const end = currentTime + frames / sampleRate;
    this.give(this.replay.take(end + HORIZON, this.batch));
    this.give(this.queue.take(end + HORIZON, this.batch));

    const pointer = this.synth.exports.synth_render(frames) / 4;
    this.synth.refresh();
    const { floats } = this.synth;
    left.set(floats.subarray(pointer, pointer + frames));
    right.set(floats.subarray(pointer + frames, pointer + 2 * frames));
    this.meter(pointer + 2 * frames, frames);
    if (this.firstSound === -1) this.lookForSound(left, right);

    this.rendered += frames;
    this.blocks += 1;
    if (this.blocks % BLOCKS_PER_TICK === 0) this.worldPort?.postMessage({ time: end });
    // Date.now counts whole milliseconds; the sum over many blocks is correct on average.
    this.busy += Date.now() - begun;
    if (this.blocks % BLOCKS_PER_REPORT === 0) this.report();
    return true;
  }

  /** @param {number} count events in the batch, on the clock of the context */
  give(count) {
    if (count === 0) return;
    // The synthesis does not advance while the context does without it, as before the first block.
    const origin = (currentFrame - this.rendered) / sampleRate;
    const events = this.batch.subarray(0, count * EVENT_STRIDE);
    for (let at = EVENT.time; at < events.length; at += EVENT_STRIDE) {
      // Events before the start, such as the pose of an object, get time 0.
      events[at] = Math.max(0, events[at] - origin);
    }
    this.synth.writeNumbers(events);
    this.synth.exports.synth_push(count);
  }

  /**
   * Level and recording, in pascals before the limiter.
   * @param {number} pointer of two planes
   * @param {number} frames
   */
  meter(pointer, frames) {
    const { floats } = this.synth;
    for (let i = pointer; i < pointer + 2 * frames; i += 1) {
      this.squares += floats[i] * floats[i];
      this.peak = Math.max(this.peak, Math.abs(floats[i]));
    }
    const { recording } = this;
    if (!recording) return;
    if (recording.filled + frames > RECORDING_CHUNK) this.sendRecording(recording);
    recording.left.set(floats.subarray(pointer, pointer + frames), recording.filled);
    recording.right.set(floats.subarray(pointer + frames, pointer + 2 * frames), recording.filled);
    recording.filled += frames;
  }

  /** @param {Float32Array} left @param {Float32Array} right */
  lookForSound(left, right) {
    for (let i = 0; i < left.length; i += 1) {
      if (Math.max(Math.abs(left[i]), Math.abs(right[i])) < AUDIBLE) continue;
      this.firstSound = currentFrame + i;
      this.port.postMessage({ kind: 'first-sound', time: this.firstSound / sampleRate });
      return;
    }
  }

  report() {
    const frames = BLOCKS_PER_REPORT * 128;
    this.port.postMessage({
      kind: 'report',
      time: currentTime,
      peak: this.peak,
      rootMeanSquare: Math.sqrt(this.squares / (2 * frames)),
      load: this.busy / ((1000 * frames) / sampleRate),
      dropped: this.queue.dropped,
      failures: this.failures,
      synth: this.synth.readNumbers(this.synth.exports.synth_report(), REPORT_STRIDE),
    });
    this.squares = 0;
    this.peak = 0;
    this.busy = 0;
  }
}

registerProcessor('clangor', SoundProcessor);
