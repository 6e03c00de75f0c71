// Debian's Firefox, driven by WebDriver BiDi. FIREFOX names another program.

import { existsSync } from 'node:fs';
import { basename } from 'node:path';
import { firefox } from 'playwright-core';
import { openScreen, openSink, PULSEAUDIO, XVFB } from './virtual-devices.mjs';

const PROGRAM = process.env.FIREFOX ?? '/usr/bin/firefox-esr';

const QUIET = {
  // Nothing is asked of other machines.
  'app.normandy.enabled': false,
  'services.settings.server': 'data:,#',
};

/** Sound may start without a gesture. */
const FREE_SOUND = { 'media.autoplay.default': 0 };

// A script of the driver counts as a gesture for Firefox, and the first one allows sound for good. With these,
// a gesture allows sound while it is fresh, so that `letGesturesFade` undoes what scripts did.
const GUARDED_SOUND = {
  'media.autoplay.default': 1,
  'media.autoplay.blocking_policy': 1,
  'dom.user_activation.transient.timeout': 200,
};

/** What Firefox needs and this machine has not, or null. */
export function missingForFirefox() {
  const missing = [PROGRAM, PULSEAUDIO, XVFB].find((program) => !existsSync(program));
  return missing ? `${basename(missing)} is not installed` : null;
}

/**
 * @param {string} profile folder
 * @param {import('./browser.mjs').Options} options
 */
export async function launchFirefox(profile, { autoplay, context }) {
  const sink = await openSink();
  const screen = await openScreen();
  const closeDevices = async () => {
    await screen.close();
    await sink.close();
  };
  try {
    const browser = await firefox.launchPersistentContext(profile, {
      channel: 'moz-firefox',
      executablePath: PROGRAM,
      headless: false,
      env: { ...process.env, DISPLAY: screen.display, PULSE_SERVER: sink.server },
      firefoxUserPrefs: { ...QUIET, ...(autoplay ? FREE_SOUND : GUARDED_SOUND) },
      ...context,
    });
    return { browser, close: () => browser.close().finally(closeDevices) };
  } catch (error) {
    await closeDevices();
    throw error;
  }
}

/**
 * Gives the page a finger: Playwright's own does nothing in a browser that is driven by BiDi.
 * @param {import('playwright-core').Page} page
 */
export function giveFinger(page) {
  const session = Reflect.get(page, '_connection').toImpl(page).delegate._session;
  page.touchscreen.tap = (x, y) =>
    session.send('input.performActions', {
      context: session.sessionId,
      actions: [
        {
          type: 'pointer',
          id: 'finger',
          parameters: { pointerType: 'touch' },
          actions: [
            { type: 'pointerMove', x: Math.round(x), y: Math.round(y) },
            { type: 'pointerDown', button: 0 },
            { type: 'pointerUp', button: 0 },
          ],
        },
      ],
    });
}

/**
 * Waits until no gesture is fresh, the one that this script itself is for Firefox included.
 * @param {import('playwright-core').Page} page
 */
export function letGesturesFade(page) {
  return page.evaluate(async () => {
    while (navigator.userActivation.isActive) await new Promise((done) => setTimeout(done, 10));
  });
}
