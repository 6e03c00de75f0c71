// A finished run, as `clangor export web` writes it, becomes what the page replays.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { EVENT, EVENT_KIND, EVENT_STRIDE } from '../src/event-layout.js';
import { readRun } from '../src/exported-run.js';
import { reason, Refusal, sentence } from '../src/messages.js';

/**
 * A safetensors file.
 * @param {object} about
 * @param {Record<string, ArrayBufferView>} arrays
 */
function tensors(about, arrays) {
  /** @type {Record<string, any>} */
  const header = { __metadata__: { clangor: JSON.stringify(about) } };
  let end = 0;
  for (const [name, { byteLength }] of Object.entries(arrays)) {
    header[name] = { data_offsets: [end, end + byteLength] };
    end += byteLength;
  }
  const text = new TextEncoder().encode(JSON.stringify(header));
  const file = new Uint8Array(8 + text.length + end);
  new DataView(file.buffer).setBigUint64(0, BigInt(text.length), true);
  file.set(text, 8);
  let at = 8 + text.length;
  for (const { buffer, byteOffset, byteLength } of Object.values(arrays)) {
    file.set(new Uint8Array(buffer, byteOffset, byteLength), at);
    at += byteLength;
  }
  return file;
}

/** A ball that moves, a shard that is born late and dies, on a plane at 45 degrees. */
function example(version = 2) {
  const eighth = [0, 0, Math.sin(Math.PI / 8), Math.cos(Math.PI / 8)];
  const life = { birth_s: 0, death_s: null, parent: null };
  const about = {
    kind: 'replay',
    version,
    duration_s: 0.1,
    frame_rate_hz: 120,
    full_scale_pa: 3,
    scene: 'version = 1\n',
    listeners: [{ name: 'ears', left: [0, 1, 0], right: [0.2, 1, 0] }],
    materials: ['glass'],
    bodies: [
      {
        ...life,
        name: 'ball',
        material: 0,
        form: 'sphere',
        radius_m: 0.01,
        first_frame: 0,
        first_row: 0,
        rows: 3,
      },
      {
        ...life,
        name: 'shard',
        material: 0,
        form: 'mesh',
        mesh: 0,
        birth_s: 0.05,
        death_s: 0.08,
        first_frame: 6,
        first_row: 3,
        rows: 2,
      },
      { ...life, name: 'slope', material: 0, form: 'plane', first_frame: 0, first_row: 5, rows: 1 },
    ],
    sounds: [{ body: 1, rotation: [0, 1, 0, 0], t60: [[1000, 0.5]] }],
  };
  const still = [0, 0, 0, 1];
  const poses = [
    [0, 0, 0, ...still],
    [0.1, 0, 0, ...still],
    [0.2, 0, 0, ...still],
    [0, 1, 0, ...still],
    [0, 2, 0, ...still],
    [0, -1, 0, ...eighth],
  ];
  const impact = new Float64Array(EVENT_STRIDE);
  impact.set([EVENT_KIND.objectImpact, 0.06, 1e-4, 0]);
  impact.set([0.3, 0, 0.4], EVENT.impulse);
  impact[EVENT.body] = 1;
  impact[EVENT.history] = 7;
  return tensors(about, {
    poses: Float32Array.from(poses.flat()),
    events: version === 1 ? impact.subarray(0, 24) : impact,
    'mesh.vertices': new Float32Array(9).fill(0.5),
    'mesh.triangles': new Uint32Array([0, 1, 2]),
    'mesh.ranges': new Uint32Array([0, 3, 0, 1]),
    'sounds.bytes': new Uint8Array([7, 8, 9]),
    'sounds.ranges': new Uint32Array([1, 2]),
  });
}

test('bodies move through their rows, rest before and after, and planes face their side', () => {
  const run = readRun(example());
  assert.equal(run.frames.length, 13);
  const x = run.frames.map(({ poses }) => poses[0]);
  assert.deepEqual(
    [x[0], x[1], x[2], x[12]].map((value) => Number(value.toFixed(3))),
    [0, 0.1, 0.2, 0.2],
  );
  assert.deepEqual([run.frames[0].poses[8], run.frames[12].poses[8]], [1, 2]);
  const [, , slope] = run.bodies;
  assert.ok(
    Math.abs(slope.normal[0] + Math.SQRT1_2) < 1e-6 && Math.abs(slope.normal[1] - Math.SQRT1_2) < 1e-6,
  );
  assert.ok(Math.abs(slope.distance + Math.SQRT1_2) < 1e-6);
});

test('events stay as they are, impacts are seen, models keep their damping', () => {
  const run = readRun(example());
  assert.equal(run.events.length, 1);
  assert.equal(run.events[0][EVENT.time], 0.06);
  assert.deepEqual([...run.models[0].bytes], [8, 9]);
  assert.equal(run.models[0].damping, '[[1000,0.5]]');
  assert.ok(Math.abs(run.contacts[0].impulse - 0.5) < 1e-12);
  const [shard] = run.solids;
  assert.deepEqual([shard.birth, shard.death, shard.body], [0.05, 0.08, 1]);
});

test('rows of version 1 are shorter, and have no force history', () => {
  const [older, newer] = [1, 2].map((version) => readRun(example(version)).events[0]);
  assert.equal(newer[EVENT.history], 7);
  newer[EVENT.history] = 0;
  assert.deepEqual(older, newer);
});

test('a file that is no run is refused in plain words', () => {
  const text = (/** @type {string} */ content) => new TextEncoder().encode(content);
  const whole = example();
  /** @type {[Uint8Array, RegExp][]} */
  const files = [
    [example(3), /^this is a run of version 3; the page reads versions 1 and 2$/],
    [text(''), /^this is not a file of Clangor$/],
    [text('this is not a run'), /^this is not a file of Clangor$/],
    [text('{"kind": "replay"}'), /^this is not a file of Clangor$/],
    [whole.slice(0, 100), /^this is not a file of Clangor$/],
    [whole.slice(0, whole.length - 8), /^the file is incomplete: its part “[a-z.]+” is missing$/],
  ];
  for (const [file, message] of files) {
    assert.throws(
      () => readRun(file),
      (error) => error instanceof Refusal && message.test(error.message),
      String(message),
    );
  }
});

test('messages are sentences, and say nothing of the insides of the program', () => {
  assert.equal(sentence('there is no room'), 'There is no room.');
  assert.equal(sentence('Gone?'), 'Gone?');
  assert.equal(reason(new Refusal('the file is damaged'), 'other'), 'the file is damaged');
  assert.equal(
    reason(new SyntaxError('Unexpected token } in JSON'), 'the file is damaged'),
    'the file is damaged',
  );
});
