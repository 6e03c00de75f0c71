// Bundles the page into web/dist: three scripts (page, world's thread, audio thread), and what they fetch
// beside them.

import { build } from 'esbuild';
import { cp, mkdir, rm } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const web = fileURLToPath(new URL('..', import.meta.url));

if (!existsSync(`${web}public/clangor.wasm`)) {
  console.error('web/public/clangor.wasm is missing: npm run wasm');
  process.exit(1);
}
await rm(`${web}dist`, { recursive: true, force: true });
await mkdir(`${web}dist`);
await build({
  entryPoints: ['main', 'world-worker', 'sound-worklet'].map((name) => `${web}src/${name}.js`),
  outdir: `${web}dist`,
  bundle: true,
  minify: true,
  format: 'esm',
  target: ['chrome110', 'firefox115', 'safari16.4'],
  loader: { '.toml': 'text' },
  legalComments: 'eof',
  logLevel: 'warning',
});
for (const [from, to] of [
  ['index.html', 'index.html'],
  ['src/style.css', 'style.css'],
  ['src/icon.svg', 'icon.svg'],
  ['public', '.'],
]) {
  await cp(`${web}${from}`, `${web}dist/${to}`, { recursive: true });
}
