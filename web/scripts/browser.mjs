// A real Chromium or Firefox that shows no window, with a profile of its own, on the page that is served from
// web/dist: for tests, for screenshots and for the soak run. CHROMIUM and FIREFOX name the programs,
// CLANGOR_PAGE an address where the page is served already.

import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { adjustDriver, launchFirefox } from './firefox.mjs';
import { serveDist } from './static-server.mjs';

const FLAGS = [
  '--no-sandbox',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

/** @typedef {{ autoplay: boolean, context: object }} Options as for `openBrowser` */

/** @param {string} profile folder @param {Options} options */
async function launchChromium(profile, { autoplay, context }) {
  const browser = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: autoplay ? [...FLAGS, '--autoplay-policy=no-user-gesture-required'] : FLAGS,
    ...context,
  });
  return { browser, close: () => browser.close() };
}

/**
 * @param {object} [options]
 * @param {'chromium' | 'firefox'} [options.browser]
 * @param {boolean} [options.autoplay] whether sound may start without a gesture
 * @param {object} [options.context] options of the browser's context, such as viewport
 */
export async function openBrowser({ browser: kind = 'chromium', autoplay = true, context = {} } = {}) {
  const launch = kind === 'firefox' ? launchFirefox : launchChromium;
  const server = process.env.CLANGOR_PAGE
    ? { address: process.env.CLANGOR_PAGE, close: async () => {} }
    : await serveDist();
  const profile = await mkdtemp(join(tmpdir(), 'clangor-page-'));
  const { browser, close } = await launch(profile, {
    autoplay,
    context: { viewport: { width: 1280, height: 800 }, ...context },
  });
  return {
    kind,
    browser,
    address: server.address,
    /** A page, and its errors, rejected promises, and requests that leave this machine or fail. */
    async open(hash = '') {
      const page = await browser.newPage();
      if (kind === 'firefox') adjustDriver(page);
      /** @type {string[]} */
      const complaints = [];
      page.on('console', (message) => {
        if (message.type() === 'error') complaints.push(message.text());
      });
      page.on('pageerror', (error) => complaints.push(String(error)));
      page.on('requestfailed', (request) => complaints.push(`failed: ${request.url()}`));
      page.on('request', (request) => {
        const url = new URL(request.url());
        if (url.protocol.startsWith('http') && url.origin !== new URL(server.address).origin) {
          complaints.push(`foreign: ${request.url()}`);
        }
      });
      await page.goto(`${server.address}${hash}`);
      await page.waitForFunction(() => Reflect.get(globalThis, 'clangor')?.history.frames.length > 0);
      return { page, complaints };
    },
    async close() {
      await close();
      await server.close();
      await rm(profile, { recursive: true, force: true, maxRetries: 5 });
    },
  };
}
