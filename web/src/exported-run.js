// A finished run from `clangor export web` (docs/format/replay.md): bodies, motion, impacts and sound models.
// It is replayed as a history, without simulation; the listener can move.

import { EVENT, EVENT_KIND, EVENT_STRIDE, POSE_STRIDE } from './event-layout.js';
import { Refusal } from './messages.js';
import { openTensors } from './model-file.js';

/** Numbers of an event in files of version 1, which have no force histories. */
const STRIDE_OF_VERSION_1 = 24;

/**
 * @typedef {object} ExportedRun
 * @property {any} about the description
 * @property {import('./world.js').Body[]} bodies
 * @property {{ name: string }[]} materials
 * @property {RunSolid[]} solids
 * @property {{ time: number, poses: Float32Array }[]} frames
 * @property {Float64Array[]} events in order of time
 * @property {import('./history.js').Contact[]} contacts
 * @property {{ slot: number, bytes: Uint8Array, damping: string }[]} models
 * @property {import('./planes-picture.js').Extent} extent
 */

/**
 * A mesh among the bodies, with its life [s].
 * @typedef {import('./strike.js').PlacedSolid & { body: number, birth: number, death: number }} RunSolid
 */

/**
 * @param {Uint8Array} file
 * @returns {ExportedRun}
 */
export function readRun(file) {
  const { about, array } = openTensors(file);
  if (about.kind !== 'replay' || ![1, 2].includes(about.version)) {
    throw new Refusal(
      about.kind === 'replay'
        ? `this is a run of version ${about.version}; the page reads versions 1 and 2`
        : 'this file of Clangor is no run: `clangor export web` writes one',
    );
  }
  const rows = new Float32Array(array('poses'));
  const path = (/** @type {number} */ body) => new Path(about.bodies[body], about.frame_rate_hz, rows);
  const bodies = about.bodies.map((/** @type {any} */ body, /** @type {number} */ index) =>
    describe(body, path(index).at(0)),
  );
  const frames = [];
  for (let frame = 0; frame <= about.duration_s * about.frame_rate_hz; frame += 1) {
    const poses = new Float32Array(bodies.length * POSE_STRIDE);
    for (let body = 0; body < bodies.length; body += 1) {
      poses.set(path(body).at(frame), body * POSE_STRIDE);
    }
    frames.push({ time: frame / about.frame_rate_hz, poses });
  }
  const events = splitRows(
    new Float64Array(array('events')),
    about.version === 1 ? STRIDE_OF_VERSION_1 : EVENT_STRIDE,
  );
  const ranges = new Uint32Array(array('sounds.ranges'));
  const sounds = new Uint8Array(array('sounds.bytes'));
  const models = about.sounds.map((/** @type {any} */ sound, /** @type {number} */ slot) => {
    const [first, length] = ranges.subarray(2 * slot, 2 * slot + 2);
    const damping = sound.t60.length > 0 ? JSON.stringify(sound.t60) : '';
    return { slot, bytes: sounds.slice(first, first + length), damping };
  });
  return {
    about,
    bodies,
    materials: about.materials.map((/** @type {string} */ name) => ({ name })),
    solids: readSolids(about, array, frames[0].poses),
    frames,
    events,
    contacts: events.filter((row) => row[EVENT.kind] <= EVENT_KIND.objectImpact).map(contactOf),
    models,
    extent: extentOf(bodies, about, rows),
  };
}

/** Pose of a body in each frame; the first row before its rows, the last row after them. */
class Path {
  /** @param {any} body @param {number} rate [Hz] @param {Float32Array} rows */
  constructor(body, rate, rows) {
    this.body = body;
    this.rate = rate;
    this.rows = rows;
  }

  /** @param {number} frame counted from the start of the run */
  at(frame) {
    const { first_frame: firstFrame, first_row: firstRow, rows: count } = this.body;
    const row = firstRow + Math.min(count - 1, Math.max(0, frame - firstFrame));
    return this.rows.subarray(row * POSE_STRIDE, (row + 1) * POSE_STRIDE);
  }
}

/** @param {any} body @param {Float32Array} pose at the start @returns {import('./world.js').Body} */
function describe(body, pose) {
  const [x, y, z, ...turn] = pose;
  const plane = body.form === 'plane';
  const normal = plane ? upward(turn) : [0, 0, 0];
  return {
    radius: body.form === 'sphere' ? body.radius_m : 0,
    material: body.material,
    free: false,
    plane,
    normal,
    distance: normal[0] * x + normal[1] * y + normal[2] * z,
  };
}

/** The y axis after a rotation. @param {number[]} turn quaternion */
function upward([x, y, z, w]) {
  return [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)];
}

/** @param {Float64Array} rows @param {number} stride numbers of each in the file */
function splitRows(rows, stride) {
  const parts = [];
  for (let at = 0; at + stride <= rows.length; at += stride) {
    const row = new Float64Array(EVENT_STRIDE);
    row.set(rows.subarray(at, at + stride));
    parts.push(row);
  }
  return parts;
}

/** @param {Float64Array} row of an impact @returns {import('./history.js').Contact} */
function contactOf(row) {
  const three = (/** @type {number} */ at) => [...row.subarray(at, at + 3)];
  return {
    time: row[EVENT.time],
    bodyA: row[EVENT.body],
    bodyB: -1,
    speed: Math.hypot(...three(EVENT.velocityChange)),
    impulse: Math.hypot(...three(EVENT.impulse)),
    duration: row[EVENT.duration],
    point: three(EVENT.point),
  };
}

/**
 * @param {any} about @param {(name: string) => ArrayBuffer} array @param {Float32Array} poses at the start
 * @returns {RunSolid[]}
 */
function readSolids(about, array, poses) {
  const vertices = new Float32Array(array('mesh.vertices'));
  const triangles = new Uint32Array(array('mesh.triangles'));
  const ranges = new Uint32Array(array('mesh.ranges'));
  /** @type {RunSolid[]} */
  const solids = [];
  about.bodies.forEach((/** @type {any} */ body, /** @type {number} */ index) => {
    if (body.form !== 'mesh') return;
    const [firstVertex, vertexCount, first, count] = ranges.subarray(4 * body.mesh, 4 * body.mesh + 4);
    const own = vertices.slice(3 * firstVertex, 3 * (firstVertex + vertexCount));
    solids.push({
      solid: {
        name: body.name,
        material: about.materials[body.material],
        vertices: own,
        triangles: triangles.slice(3 * first, 3 * (first + count)),
        lowest: NaN,
        radius: NaN,
      },
      slot: -1,
      key: index,
      body: index,
      position: [...poses.subarray(index * POSE_STRIDE, index * POSE_STRIDE + 3)],
      birth: body.birth_s,
      death: body.death_s ?? Infinity,
    });
  });
  return solids;
}

/**
 * A box around all moving bodies, enlarged by half.
 * @param {import('./world.js').Body[]} bodies
 * @param {any} about
 * @param {Float32Array} rows
 */
function extentOf(bodies, about, rows) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  about.bodies.forEach((/** @type {any} */ body, /** @type {number} */ index) => {
    if (bodies[index].plane) return;
    // Only the initial poses: pieces that fly away would enlarge the box too much.
    for (let axis = 0; axis < 3; axis += 1) {
      const x = rows[body.first_row * POSE_STRIDE + axis];
      low[axis] = Math.min(low[axis], x);
      high[axis] = Math.max(high[axis], x);
    }
  });
  const floor = bodies.filter((body) => body.normal[1] > 0.999).map((body) => body.distance);
  low[1] = Math.min(low[1], ...floor);
  const margin = Math.max(0.2, 0.5 * Math.hypot(...high.map((x, axis) => x - low[axis])));
  return {
    low: low.map((x, axis) => (axis === 1 ? x : x - margin)),
    high: high.map((x) => x + margin),
  };
}
