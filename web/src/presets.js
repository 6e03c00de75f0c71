// The scenes of the page: content, view, listeners and full-scale pressure.

import { isReflecting } from './room.js';
import newtonsCradle from '../../scenes/newtons-cradle.toml';
import poolBreak from '../../scenes/pool-break.toml';
import drops from './presets/drops.toml';
import marblePile from './presets/marble-pile.toml';
import objects from './presets/objects.toml';
import sculpture from './presets/sculpture.toml';
import trickShot from './presets/trick-shot.toml';
import { boxScene, halfEdge } from './sphere-box.js';

/**
 * @typedef {object} Preset
 * @property {string} id
 * @property {string} name
 * @property {string} story one sentence under the picture
 * @property {string} how hint about the gestures
 * @property {(box: import('./sphere-box.js').BoxSettings) => string} scene text
 * @property {(box: import('./sphere-box.js').BoxSettings) => import('./planes-picture.js').Extent} extent
 * @property {import('./orbit-camera.js').View} view
 * @property {number[][]} ears places of the four listeners [m]
 * @property {number} fullScale pressure at full scale [Pa]
 * @property {boolean} [room] whether it starts in a room
 * @property {Drop} drop the ball that a gesture adds
 * @property {RainPlan} [rain]
 * @property {import('./exported-run.js').ExportedRun} [run] instead of a scene that is simulated
 * @property {{ model: string, position: number[] }[]} [objects] loaded objects: file, position of the lowest
 *   point [m]
 */

/** @typedef {{ material: string, radius: number, height: number }} Drop name, [m], [m] above the ground */

/**
 * @typedef {object} RainPlan
 * @property {number} interval
 * @property {number} most
 * @property {string[]} materials
 * @property {[number, number]} radii
 * @property {[number[], number[]]} region
 */

/** @param {string} text */
const fixed = (text) => () => text;

/** @param {number[]} low @param {number[]} high */
const within = (low, high) => () => ({ low, high });

/** @type {Preset[]} */
export const PRESETS = [
  {
    id: 'drops',
    name: 'Drops',
    story:
      'Balls of steel, glass, ceramic and plastic fall on granite. ' +
      'Each click is the ball being stopped within a ten-thousandth of a second.',
    how: 'Tap the air to drop a ball, drag a ball to throw it, drag the air to look around.',
    scene: fixed(drops),
    extent: within([-0.3, 0, -0.3], [0.3, 0.42, 0.3]),
    view: { target: [0, 0.18, 0], distance: 1.08, azimuth: 24, elevation: 17 },
    ears: [
      [0.25, 0.32, 0.5],
      [-0.7, 0.3, 0.1],
      [0, 0.9, -0.2],
      [0.05, 0.08, 0.26],
    ],
    fullScale: 8,
    room: true,
    drop: { material: 'steel', radius: 0.012, height: 0.5 },
    rain: {
      interval: 0.55,
      most: 36,
      materials: ['glass', 'steel', 'plastic', 'ceramic', 'glass'],
      radii: [0.007, 0.017],
      region: [
        [-0.2, 0.6, -0.2],
        [0.2, 0.85, 0.2],
      ],
    },
  },
  {
    id: 'cradle',
    name: 'Newton’s cradle',
    story:
      'Five hung steel balls. The impact runs through the middle ones; ' +
      'only the outer two move enough to be heard.',
    how: 'Drag an outer ball aside and let go to throw it. Pause, then listen again in slow motion.',
    scene: fixed(newtonsCradle),
    extent: within([-0.2, 0, -0.12], [0.2, 0.26, 0.12]),
    view: { target: [0, 0.16, 0], distance: 0.66, azimuth: 18, elevation: 9 },
    ears: [
      [-0.15, 0.24, 0.2],
      [0.5, 0.12, 0],
      [0, 0.12, -0.4],
      [0, 0.1, 0.06],
    ],
    fullScale: 4,
    room: true,
    drop: { material: 'steel', radius: 0.011, height: 0.3 },
  },
  {
    id: 'pool',
    name: 'Pool break',
    story: 'Seven metres per second into fifteen balls: one impact becomes dozens within milliseconds.',
    how: 'Drag any ball to shoot it. “Start again” sets the rack up.',
    scene: fixed(poolBreak),
    extent: within([-1.27, 0, -0.635], [1.27, 0.06, 0.635]),
    view: { target: [0, 0, 0.02], distance: 2.75, azimuth: -20, elevation: 31 },
    ears: [
      [0.2, 0.7, 0.5],
      [-1.5, 0.6, 0],
      [1.6, 0.5, 0.1],
      [0.7, 0.12, 0.3],
    ],
    fullScale: 12,
    room: true,
    drop: { material: 'phenolic', radius: 0.028575, height: 0.3 },
  },
  {
    id: 'trick',
    name: 'Trick shot',
    story:
      'Two cushions, then gaps that shrink: every ball hands its motion to the next, ' +
      'and the clicks come faster and faster.',
    how: 'Drag any ball to shoot it. “Start again” sets the row up.',
    scene: fixed(trickShot),
    extent: within([-1.27, 0, -0.635], [1.27, 0.06, 0.635]),
    view: { target: [0, 0, 0.02], distance: 2.4, azimuth: 14, elevation: 28 },
    ears: [
      [0.2, 0.7, 0.5],
      [-1.5, 0.6, 0],
      [1.6, 0.5, 0.1],
      [0.3, 0.12, 0.25],
    ],
    fullScale: 6,
    room: true,
    drop: { material: 'phenolic', radius: 0.028575, height: 0.3 },
  },
  {
    id: 'pile',
    name: 'Marble pile',
    story: 'Three hundred glass marbles down a funnel: thousands of small clicks become one sound.',
    how: 'Tap the air to add one, drag a marble to pull it out.',
    scene: fixed(marblePile),
    extent: within([-0.2, 0, -0.2], [0.2, 0.2, 0.2]),
    view: { target: [0, 0.13, 0], distance: 0.95, azimuth: 30, elevation: 24 },
    ears: [
      [0.3, 0.4, 0.5],
      [-0.8, 0.3, 0],
      [0, 0.9, 0],
      [0.02, 0.22, 0.2],
    ],
    fullScale: 8,
    drop: { material: 'glass', radius: 0.012, height: 0.5 },
  },
  {
    id: 'sculpture',
    name: 'Spring ring',
    story:
      'Twelve brass balls on springs that get stiffer round the ring: ' +
      'together at first, then in ever new rhythms.',
    how: 'Drag a ball to set it going again; pull it down or aside.',
    scene: fixed(sculpture),
    extent: within([-0.3, 0, -0.3], [0.3, 0.5, 0.3]),
    view: { target: [0, 0.23, 0], distance: 1.15, azimuth: 20, elevation: 16 },
    ears: [
      [0, 0.45, 0.55],
      [-0.6, 0.2, 0],
      [0, 0.05, -0.4],
      [0, 0.1, 0],
    ],
    fullScale: 2.5,
    room: true,
    drop: { material: 'glass', radius: 0.01, height: 0.45 },
  },
  {
    id: 'objects',
    name: 'Bowl & glass',
    story:
      'A bowl, a wine glass, a plate and a coin with the modes of their real shapes. ' +
      'Where you hit decides what rings.',
    how: 'Tap an object where you want to hit it: rim, wall or foot. Choose the mallet and its speed below.',
    scene: fixed(objects),
    extent: within([-0.34, 0, -0.3], [0.34, 0.3, 0.3]),
    view: { target: [0, 0.045, 0], distance: 0.88, azimuth: 8, elevation: 27 },
    ears: [
      [0.05, 0.35, 0.5],
      [-0.6, 0.2, 0.1],
      [0.6, 0.1, -0.1],
      [0.0, 0.16, 0.16],
    ],
    fullScale: 1.5,
    room: true,
    drop: { material: 'steel', radius: 0.008, height: 0.3 },
    objects: [
      { model: 'bowl', position: [-0.13, 0, 0.03] },
      { model: 'wineglass', position: [0.03, 0, -0.1] },
      { model: 'plate', position: [0.17, 0, 0.04] },
      { model: 'coin', position: [0.01, 0, 0.13] },
    ],
  },
  {
    id: 'box',
    name: 'Sphere box',
    story: 'As many balls as you like in a closed box, with gravity or without.',
    how: 'Choose material, size, number and walls. Without gravity the box never comes to rest for long.',
    scene: boxScene,
    extent: (box) => {
      const half = halfEdge(box);
      return { low: [-half, 0, -half], high: [half, 2 * half, half] };
    },
    view: { target: [0, 0.15, 0], distance: 0.9, azimuth: 28, elevation: 18 },
    ears: [
      [0.25, 0.3, 0.45],
      [-0.6, 0.2, 0],
      [0, 0.7, 0],
      [0, 0.15, 0],
    ],
    fullScale: 5,
    drop: { material: 'steel', radius: 0.01, height: 0.25 },
  },
];

/**
 * A run from a file, as a scene among the others.
 * @param {import('./exported-run.js').ExportedRun} run
 * @param {string} name of the file
 * @returns {Preset}
 */
export function presetOfRun(run, name) {
  const { low, high } = run.extent;
  const middle = low.map((x, axis) => (x + high[axis]) / 2);
  const size = Math.hypot(...high.map((x, axis) => x - low[axis]));
  const ears = run.about.listeners
    .slice(0, 4)
    .map((/** @type {any} */ { left, right }) =>
      left.map((/** @type {number} */ x, /** @type {number} */ axis) => (x + right[axis]) / 2),
    );
  const around = [
    [0.6, 0.4, 0.6],
    [-0.7, 0.3, 0.1],
    [0, 0.9, -0.2],
    [0.1, 0.1, -0.5],
  ].map((part) => part.map((x, axis) => middle[axis] + size * x));
  return {
    id: 'run',
    name,
    story:
      `${run.bodies.length} bodies, ${run.contacts.length} impacts in ` +
      `${run.about.duration_s.toFixed(1)} seconds: a finished run. Listen from wherever you like.`,
    how: 'Move the slider, choose a speed, drag a numbered head and play again.',
    scene: fixed(run.about.scene),
    room: isReflecting(run.about.scene),
    extent: () => run.extent,
    view: { target: middle, distance: 1.5 * size, azimuth: 25, elevation: 18 },
    ears: [...ears, ...around.slice(ears.length)],
    fullScale: run.about.full_scale_pa,
    drop: { material: 'steel', radius: 0.01, height: 0.3 },
    run,
  };
}
