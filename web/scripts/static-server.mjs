// Serves web/dist to this machine, for tests and for looking at it: `node scripts/static-server.mjs [PORT]`.
// `clangor serve` is the program for users.

import { createServer } from 'node:http';
import { existsSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

const DIST = fileURLToPath(new URL('../dist', import.meta.url));

/** @type {Record<string, string>} */
const TYPES = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
  '.safetensors': 'application/octet-stream',
};

/**
 * @param {number} [port] 0 for any
 * @returns {Promise<{ address: string, close: () => Promise<void> }>}
 */
export async function serveDist(port = 0) {
  for (const file of ['index.html', 'clangor.wasm', 'models']) {
    if (!existsSync(join(DIST, file))) throw new Error(`web/dist/${file} is missing: npm run build`);
  }
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url ?? '/', 'http://here').pathname));
    const file = join(DIST, path.endsWith('/') ? `${path}index.html` : path);
    try {
      if (!file.startsWith(DIST)) throw new Error('outside');
      const content = await readFile(file);
      response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'text/plain' }).end(content);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((listening) => server.listen(port, '127.0.0.1', () => listening(undefined)));
  const { port: chosen } = /** @type {import('node:net').AddressInfo} */ (server.address());
  return {
    address: `http://127.0.0.1:${chosen}/`,
    close: () =>
      new Promise((closed) => {
        server.closeAllConnections();
        server.close(() => closed());
      }),
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { address } = await serveDist(Number(process.argv[2] ?? 8000));
  console.log(address);
}
