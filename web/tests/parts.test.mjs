// The parts of the page that need no browser.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { WorldClock, LEAD } from '../src/clock.js';
import { EVENT, EVENT_KIND, EVENT_STRIDE } from '../src/event-layout.js';
import { EventQueue } from '../src/event-queue.js';
import { History } from '../src/history.js';
import { ReplayFeeder } from '../src/replay-feeder.js';
import { ROWS_AT_ONCE, takeForceRows } from '../src/force-rows.js';
import { randomNumbers } from '../src/rain.js';
import { inRoom, isReflecting } from '../src/room.js';
import { boxScene } from '../src/sphere-box.js';
import { wavFile } from '../src/wav-file.js';

/** @param {number[]} times */
function eventsAt(times) {
  const events = new Float64Array(times.length * EVENT_STRIDE);
  times.forEach((time, row) => {
    events[row * EVENT_STRIDE + EVENT.time] = time;
    events[row * EVENT_STRIDE + EVENT.body] = row;
  });
  return events;
}

test('the queue hands out events in order of time, equals in order of arrival, and no more than fit', () => {
  const random = randomNumbers(1);
  const times = Array.from({ length: 500 }, () => Math.floor(100 * random()) / 100);
  const queue = new EventQueue(512);
  queue.add(eventsAt(times));
  const target = new Float64Array(64 * EVENT_STRIDE);
  const taken = [];
  for (let count = queue.take(0.5, target); count > 0; count = queue.take(0.5, target)) {
    for (let row = 0; row < count; row += 1) {
      const at = row * EVENT_STRIDE;
      taken.push([target[at + EVENT.time], target[at + EVENT.body]]);
    }
  }
  const expected = times
    .map((time, body) => [time, body])
    .filter(([time]) => time < 0.5)
    .sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  assert.deepEqual(taken, expected);
  assert.equal(queue.count, times.length - expected.length);
});

test('the queue drops and counts what has no time and what does not fit', () => {
  const queue = new EventQueue(4);
  queue.add(eventsAt([NaN, 1, Infinity, 2, -Infinity, 3, 4, 5, 6]));
  assert.equal(queue.count, 4);
  assert.equal(queue.dropped, 5);
  queue.clear();
  queue.add(eventsAt([7]));
  assert.equal(queue.take(8, new Float64Array(EVENT_STRIDE)), 1);
});

test('the world leads the sound, skips what is too far behind, and never goes back', () => {
  const clock = new WorldClock();
  assert.equal(clock.due(10, 0), 0);
  const offset = /** @type {number} */ (clock.offset);
  // Rounded to whole samples.
  assert.ok(Math.abs(offset - (10 + LEAD)) < 1e-4);
  assert.ok(Math.abs(clock.due(10.01, 0) - 0.01) < 1e-4);
  assert.equal(clock.due(10.01, 0.02), 0.02);
  assert.equal(clock.due(11, 0.02), 0.02);
  assert.equal(clock.skips, 1);
  assert.ok(Math.abs(clock.due(11.01, 0.02) - 0.03) < 1e-4);
  assert.equal(clock.due(NaN, 0.5), 0.5);
  for (const shift of [offset, /** @type {number} */ (clock.offset)]) {
    assert.ok(Math.abs(shift * 48000 - Math.round(shift * 48000)) < 1e-6);
  }
});

test('a replay shifts events by whole samples, and stretches time when it is slow', () => {
  const feeder = new ReplayFeeder();
  const target = new Float64Array(8 * EVENT_STRIDE);
  feeder.start(eventsAt([2, 3, 4]), 1.5, 1, 100.00001, 48000);
  assert.equal(feeder.take(101.6, target), 2);
  const shift = target[EVENT.time] - 2;
  assert.ok(Math.abs(shift * 48000 - Math.round(shift * 48000)) < 1e-6);
  assert.ok(shift - (100.00001 - 1.5) < 1 / 48000);
  feeder.start(eventsAt([1, 2, 3, 4]), 1, 0.25, 100, 48000);
  assert.equal(feeder.take(1e9, target), 4);
  const spacing = target[EVENT_STRIDE + EVENT.time] - target[EVENT.time];
  assert.ok(Math.abs(spacing - 4) < 1e-9);
});

test('force histories go ahead of their impacts, which wait for their time', () => {
  const rows = eventsAt(Array.from({ length: 3000 }, (_, row) => 1 + row / 1000));
  for (let row = 0; row < 3000; row += 1) {
    if (row % 3 > 0) rows[row * EVENT_STRIDE + EVENT.kind] = EVENT_KIND.forceHistory;
  }
  /** @type {number[]} */
  const ahead = [];
  takeForceRows(rows, (part, count) => {
    assert.ok(count <= ROWS_AT_ONCE && part.length === count * EVENT_STRIDE);
    for (let row = 0; row < count; row += 1) ahead.push(part[row * EVENT_STRIDE + EVENT.body]);
  });
  const all = Array.from({ length: 3000 }, (_, row) => row);
  assert.deepEqual(
    ahead,
    all.filter((row) => row % 3 > 0),
  );
  const queue = new EventQueue(1000);
  queue.add(rows);
  assert.deepEqual([queue.count, queue.dropped], [1000, 0]);
  const feeder = new ReplayFeeder();
  feeder.start(rows, 1, 1, 1, 48000);
  const target = new Float64Array(1024 * EVENT_STRIDE);
  assert.equal(feeder.take(1e9, target), 1000);
  assert.equal(target[999 * EVENT_STRIDE + EVENT.body], 2997);
});

test('the history keeps half a minute and interpolates poses', () => {
  const history = new History();
  const none = new Float64Array(0);
  for (let frame = 0; frame <= 6000; frame += 1) {
    const time = frame / 75;
    const poses = new Float32Array([time, 0, 0, 0, 0, 0, 1]);
    history.add({ time, offset: 0, skips: 0, poses, contacts: none, events: none });
  }
  assert.ok(history.end - history.start >= 30);
  assert.ok(history.end - history.start < 32);
  const target = new Float32Array(7);
  assert.equal(history.poses(70.005, target), 1);
  assert.ok(Math.abs(target[0] - 70.005) < 1e-4);
  assert.equal(history.poses(1e9, target), 1);
  assert.equal(target[0], 80);
});

test('from a moment on there are its events, and where what rings was last, unless it is no more', () => {
  const history = new History();
  const add = (/** @type {number} */ kind, /** @type {number} */ time, /** @type {number} */ slot) => {
    const event = new Float64Array(EVENT_STRIDE);
    event.set([kind, time, 0, slot]);
    history.addEvent(event);
  };
  add(EVENT_KIND.pose, 1, 0);
  add(EVENT_KIND.pose, 2, 0);
  add(EVENT_KIND.pose, 2, 1);
  add(EVENT_KIND.end, 2.5, 1);
  add(EVENT_KIND.objectImpact, 4, 0);
  add(EVENT_KIND.sphereImpact, 3.5, 0);
  add(EVENT_KIND.sphereImpact, 2.7, 0);
  const rows = history.eventsFrom(3);
  const times = [0, 1, 2].map((row) => rows[row * EVENT_STRIDE + EVENT.time]);
  assert.equal(rows.length, 3 * EVENT_STRIDE);
  assert.deepEqual(times, [2, 3.5, 4]);
});

test('a recording is a WAV file of 32-bit floats', () => {
  const file = wavFile(
    [new Float32Array([1, 2]), new Float32Array([3])],
    [new Float32Array([-1, -2]), new Float32Array([-3])],
    48000,
  );
  const view = new DataView(file.buffer);
  assert.equal(new TextDecoder().decode(file.subarray(0, 4)), 'RIFF');
  assert.equal(view.getUint32(4, true), file.length - 8);
  assert.equal(view.getUint16(20, true), 3);
  assert.equal(view.getUint32(24, true), 48000);
  const data = file.length - 24;
  assert.equal(view.getUint32(data - 4, true), 24);
  assert.deepEqual(
    [0, 1, 2, 3, 4, 5].map((i) => view.getFloat32(data + 4 * i, true)),
    [1, -1, 2, -2, 3, -3],
  );
});

test('the sphere box holds the number of balls that was asked for', () => {
  for (const count of [1, 2, 5, 50, 2000]) {
    for (const gravity of [true, false]) {
      const text = boxScene({ material: 'mixed', walls: 'glass', radius: 0.01, count, gravity });
      const counts = [...text.matchAll(/^count = (\d+)$/gm)].map((match) => Number(match[1]));
      assert.equal(
        counts.reduce((a, b) => a + b, 0),
        count,
      );
    }
  }
});

test('a scene gets a room unless something of it reflects', () => {
  const extent = { low: [-0.1, 0, -0.1], high: [0.1, 0.3, 0.1] };
  const floor = 'version = 1\n[render]\nfloor = "rigid"\n';
  const inside = inRoom(floor, extent);
  assert.match(inside, /^\[room\]$/m);
  assert.doesNotMatch(inside, /floor = "rigid"/);
  assert.ok(isReflecting(floor));
  assert.ok(!isReflecting('version = 1\n[[plane]]\nmaterial = "wood"'));
  for (const own of ['[room]\nlowest = [0, 0, 0]', '[[plane]]\nmaterial = "wood"\nreflects = true']) {
    assert.equal(inRoom(floor + own, extent), floor + own);
    assert.ok(isReflecting(own));
  }
});
