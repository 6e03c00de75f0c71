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

/** Values of `media.autoplay.default`. */
const AUTOPLAY = { allowed: 0, blocked: 1 };

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
      firefoxUserPrefs: {
        ...QUIET,
        'media.autoplay.default': autoplay ? AUTOPLAY.allowed : AUTOPLAY.blocked,
      },
      ...context,
    });
    return { browser, close: () => browser.close().finally(closeDevices) };
  } catch (error) {
    await closeDevices();
    throw error;
  }
}

/**
 * Adjusts what Playwright does in a browser that is driven by BiDi: its taps do nothing there, and each
 * script that it runs counts as a gesture, which would allow the sound.
 * @param {import('playwright-core').Page} page
 */
export function adjustDriver(page) {
  const session = Reflect.get(page, '_connection').toImpl(page).delegate._session;
  const send = session.send.bind(session);
  session.send = (/** @type {string} */ command, /** @type {object} */ parameters) =>
    send(command, command.startsWith('script.') ? { ...parameters, userActivation: false } : parameters);
  page.touchscreen.tap = (x, y) =>
    send('input.performActions', {
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
