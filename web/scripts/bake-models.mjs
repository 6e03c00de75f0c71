// Bakes the objects that can be struck into web/public/models, with the program `clangor`: that of CLANGOR,
// or of target/release, which is built if it is not there. What has been baked stays.

import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, renameSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('../..', import.meta.url));
const folder = `${root}web/public/models`;

/** Shape, material, highest frequency [Hz]: low enough that the files stay small. */
const OBJECTS = [
  ['bowl', 'ceramic', 12000],
  ['wineglass', 'glass', 10000],
  ['plate', 'ceramic', 7000],
  ['coin', 'copper', 20000],
];

/** @param {string} program @param {string[]} options */
function run(program, options) {
  const { status, error } = spawnSync(program, options, { cwd: root, stdio: 'inherit' });
  if (status !== 0) {
    console.error(`${program} ${options.join(' ')} failed${error ? `: ${error.message}` : ''}`);
    process.exit(1);
  }
}

function builtProgram() {
  const built = `${process.env.CARGO_TARGET_DIR ?? `${root}target`}/release/clangor`;
  if (!existsSync(built)) run('cargo', ['build', '--release', '--bin', 'clangor']);
  return built;
}

const missing = OBJECTS.filter(([shape]) => !existsSync(`${folder}/${shape}.safetensors`));
if (missing.length > 0) {
  const program = process.env.CLANGOR ?? builtProgram();
  mkdirSync(folder, { recursive: true });
  for (const [shape, material, band] of missing) {
    const file = `${folder}/${shape}.safetensors`;
    run(program, [
      '--quiet',
      'bake',
      `${shape}`,
      '--material',
      `${material}`,
      '--max-frequency',
      `${band}`,
      '--no-near-field',
      '-o',
      `${folder}/part.safetensors`,
    ]);
    renameSync(`${folder}/part.safetensors`, file);
  }
}
