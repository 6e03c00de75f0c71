// The room around every scene: the size of a living room for small scenes, of a hall for a table; plaster
// walls, a wooden floor at the height of the ground, curtains on one side.

/** Position of the middle of the scene in the room, as parts of its width and depth. */
const SCENE_POSITION = [0.42, 0.45];

/** Least size of the room [m]. */
const SIZE = [4.2, 2.7, 5.1];

/** A room or planes of the scene itself that reflect. */
const OWN_REFLECTORS = /^\s*(\[room\]|reflects\s*=\s*true)/m;

/**
 * Whether something of a scene reflects sound.
 * @param {string} scene
 * @returns {boolean}
 */
export function isReflecting(scene) {
  return OWN_REFLECTORS.test(scene) || /^\s*floor\s*=\s*"rigid"/m.test(scene);
}

/**
 * The text of a scene for the sound, with a room around it, unless it has a room or planes that reflect.
 * Without reflections, the field is free.
 * @param {string} scene
 * @param {import('./planes-picture.js').Extent} extent
 * @returns {string}
 */
export function inRoom(scene, extent) {
  if (OWN_REFLECTORS.test(scene)) return scene;
  const [width, height, depth] = SIZE.map((least, axis) =>
    Math.max(least, extent.high[axis] - extent.low[axis] + 2),
  );
  const [x, z] = [0, 2].map((axis) => (extent.low[axis] + extent.high[axis]) / 2);
  const lowest = [x - SCENE_POSITION[0] * width, extent.low[1], z - SCENE_POSITION[1] * depth];
  const highest = [lowest[0] + width, lowest[1] + height, lowest[2] + depth];
  // A rigid floor and a room exclude each other: the room has a floor of its own.
  return `${scene.replace(/^floor = "rigid"$/m, '')}
[room]
lowest = [${lowest}]
highest = [${highest}]
images = 1

[room.absorption]
walls = [0.15, 0.1, 0.08, 0.07, 0.07, 0.08, 0.1]
floor = [0.15, 0.12, 0.1, 0.08, 0.08, 0.09, 0.1]
z_high = [0.1, 0.3, 0.4, 0.5, 0.5, 0.5, 0.5]
`;
}
