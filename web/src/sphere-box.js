// The scene of the sphere box, from its settings: number, material and size of the balls, and the walls. The
// materials are those of Table 1 in [HW], and real steel.

/** Materials of the balls. */
export const BALL_MATERIALS = {
  steel: 'Steel',
  glass: 'Glass',
  ceramic: 'Ceramic',
  plastic: 'Plastic',
  'table-steel': 'Steel of Table 1',
  mixed: 'All of them',
};

export const WALL_MATERIALS = {
  granite: 'Granite',
  glass: 'Glass',
  wood: 'Wood',
  steel: 'Steel',
  rubber: 'Rubber',
};

/** Steps of the slider for the number of balls. */
export const COUNTS = [1, 2, 5, 10, 20, 50, 100, 200, 300, 500, 1000, 2000];

/**
 * @typedef {object} BoxSettings
 * @property {keyof typeof BALL_MATERIALS} material
 * @property {keyof typeof WALL_MATERIALS} walls
 * @property {number} radius [m]
 * @property {number} count
 * @property {boolean} gravity
 */

/** Velocities without gravity, in equal numbers [m/s]; with gravity the balls start at rest. */
const DRIFTS = [
  [0.6, 0.5, 0.3],
  [-0.6, -0.4, 0.5],
  [0.3, -0.6, -0.5],
  [-0.3, 0.5, -0.6],
];
const LET_GO = [[0, 0, 0]];

/**
 * Half the edge of the box [m]: the balls fill at most a thirtieth of it, so that random placement succeeds.
 * @param {BoxSettings} settings
 */
export function halfEdge({ radius, count }) {
  const balls = count * (4 / 3) * Math.PI * (1.1 * radius) ** 3;
  return Math.max(0.15, 4 * radius, 0.5 * Math.cbrt(30 * balls));
}

/**
 * @param {BoxSettings} settings
 * @returns {string} a scene
 */
export function boxScene(settings) {
  const { material, walls, radius, count, gravity } = settings;
  const half = halfEdge(settings);
  const names =
    material === 'mixed' ? Object.keys(BALL_MATERIALS).filter((name) => name !== 'mixed') : [material];
  const parts = [
    `version = 1
gravity = [0.0, ${gravity ? -9.80665 : 0}, 0.0]

[material.table-steel]
base = "copper"
source = "[HW] Table 1"

[simulation]
duration = 3600.0
`,
  ];
  const inner = half - 1.05 * radius;
  const starts = gravity ? LET_GO : DRIFTS;
  const kinds = names.flatMap((name) => starts.map((velocity) => ({ name, velocity })));
  kinds.forEach(({ name, velocity }, index) => {
    const share = Math.floor((count + kinds.length - 1 - index) / kinds.length);
    if (share === 0) return;
    const lowest = [-inner, 1.05 * radius, -inner];
    const highest = [inner, half + inner, inner];
    parts.push(`[[body]]
name = "${name}-${index}"
shape = "sphere:${radius}"
material = "${name}"
count = ${share}
placement = { region = [[${lowest}], [${highest}]], seed = 5 }
velocity = [${velocity}]
`);
  });
  const sides = [
    ['floor', [0, 0, 0], [0, 1, 0]],
    ['ceiling', [0, 2 * half, 0], [0, -1, 0]],
    ['left', [-half, 0, 0], [1, 0, 0]],
    ['right', [half, 0, 0], [-1, 0, 0]],
    ['back', [0, 0, -half], [0, 0, 1]],
    ['front', [0, 0, half], [0, 0, -1]],
  ];
  for (const [name, point, normal] of sides) {
    parts.push(`[[plane]]
name = "${name}"
point = [${point}]
normal = [${normal}]
material = "${walls}"
thin = ${name !== 'floor'}
`);
  }
  return parts.join('\n');
}
