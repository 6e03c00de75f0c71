// The first tap, click or key on every scene is heard, and logged with its own values.

import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import { openBrowser } from '../scripts/browser.mjs';
import { missingForFirefox } from '../scripts/firefox.mjs';
import { EVENT } from '../src/event-layout.js';
import { hear, HEARD, listen, PATIENCE } from './audio-clock.mjs';

const BROWSERS = /** @type {const} */ (['chromium', 'firefox']);

const SCENES = ['drops', 'cradle', 'pool', 'trick', 'pile', 'sculpture', 'objects', 'box'];

/** Seconds of sound in which every scene has been heard: the slowest is the first swing of the springs. */
const SOON = 3;

/** Longest time of a test [ms]: the driver waits for a page that hangs without end. */
const LONGEST = 5 * PATIENCE.timeout;

/** Part of the window that is tapped: beside the middle, where most scenes have nothing. */
const TAPPED = [0.42, 0.4];

/** @typedef {import('playwright-core').Page} Page */

/** @type {Awaited<ReturnType<typeof openBrowser>>} */
let session;

/** The first gestures, by name. @type {Record<string, (page: Page, scene: string) => Promise<void>>} */
const GESTURES = {
  mouse: (page) => page.mouse.click(...at(page)),
  touch: (page) => page.touchscreen.tap(...at(page)),
  keyboard: (page, scene) => page.keyboard.press(scene === 'objects' ? 's' : 'd'),
};

/** @param {Page} page @returns {[number, number]} */
function at(page) {
  const { width, height } = /** @type {{ width: number, height: number }} */ (page.viewportSize());
  return [TAPPED[0] * width, TAPPED[1] * height];
}

/** Opens a scene by its address and waits until all of it is there. @param {string} scene */
async function opened(scene) {
  const { page, complaints } = await session.open(`#${scene}`);
  await page.waitForFunction(() => Reflect.get(globalThis, 'clangor').stage.ready, null, PATIENCE);
  await page.evaluate(() => {
    /** @type {HTMLDetailsElement} */ (document.getElementById('log-details')).open = true;
  });
  await listen(page);
  assert.equal(await page.evaluate(() => Reflect.get(globalThis, 'clangor').sound.context), null);
  // In Chromium, the scripts of the driver count as gestures.
  if (session.kind === 'firefox') {
    assert.equal(await page.evaluate(() => navigator.userActivation.hasBeenActive), false);
  }
  return { page, complaints };
}

/**
 * Every logged contact has events of its own bodies at its own time.
 * @param {Page} page
 */
async function checkLog(page) {
  await page.waitForFunction(() => document.querySelector('#log li'), null, PATIENCE);
  const { contacts, strangers } = await page.evaluate((row) => {
    const { history } = Reflect.get(globalThis, 'clangor');
    const events = history.events.map((/** @type {any} */ entry) => entry.event);
    const own = (/** @type {any} */ { time, bodyA, bodyB }) =>
      events.some(
        (/** @type {Float64Array} */ event) =>
          Math.abs(event[row.time] - time) < 1e-9 && [bodyA, bodyB, -2 - bodyA].includes(event[row.body]),
      );
    return {
      contacts: history.contacts.length,
      strangers: history.contacts.filter((/** @type {any} */ contact) => !own(contact)),
    };
  }, EVENT);
  assert.ok(contacts > 0);
  assert.deepEqual(strangers, []);
}

/** @param {string} scene @param {string} name of the gesture */
async function tryFirst(scene, name) {
  const { page, complaints } = await opened(scene);
  await GESTURES[name](page, scene);
  const { peak, first, time } = await hear(page, SOON);
  const begun = `${first?.toFixed(2)} s of ${time.toFixed(2)} s`;
  console.log(`${session.kind}, ${scene}, ${name}: ${peak.toPrecision(2)} Pa, ${begun}`);
  assert.ok(peak > HEARD && first !== null, `${name}: ${peak} Pa`);
  await checkLog(page);
  assert.equal(await page.isHidden('#wake'), true);
  assert.equal(await page.isHidden('#trouble'), true, (await page.textContent('#trouble')) ?? '');
  assert.deepEqual(complaints, []);
  await page.close();
}

/** Both wait for the sound, in the order and with the values of their own. */
async function tryTwoTaps() {
  const { page, complaints } = await opened('objects');
  // The audio thread starts only when both taps are done.
  await page.evaluate(() => {
    const { sound } = Reflect.get(globalThis, 'clangor');
    const build = sound.build.bind(sound);
    sound.build = async (/** @type {any[]} */ ...parts) => {
      await new Promise((done) => Reflect.set(globalThis, 'release', done));
      return build(...parts);
    };
  });
  const taps = [
    ['wineglass', 0.4, 'steel'],
    ['plate', 1.5, 'rubber'],
  ];
  for (const [name, speed, mallet] of taps) {
    const [x, y] = await page.evaluate(([object, strikeSpeed, malletName]) => {
      const { stage, picture } = Reflect.get(globalThis, 'clangor');
      Object.assign(stage, { strikeSpeed, mallet: malletName });
      // A point of the object that is seen, found as a tap finds it.
      const { clientWidth, clientHeight } = picture.canvas;
      for (let pixel = 0; pixel < clientWidth * clientHeight; pixel += 7) {
        const [column, row] = [pixel % clientWidth, Math.floor(pixel / clientWidth)];
        if (document.elementFromPoint(column, row) !== picture.canvas) continue;
        picture.aim(column, row);
        const hit = picture.solids.hit(picture.ray);
        if (hit?.object.solid.name === object) return [column, row];
      }
      return [0, 0];
    }, /** @type {const} */ ([name, speed, mallet]));
    await page.mouse.click(x + 2, y + 2);
  }
  assert.equal(await page.evaluate(() => Reflect.get(globalThis, 'clangor').sound.on), false);
  await page.evaluate(() => Reflect.get(globalThis, 'release')());
  assert.ok((await hear(page, SOON)).peak > HEARD);
  await page.waitForFunction(() => document.querySelectorAll('#log li').length === 2, null, PATIENCE);
  const logged = await page.evaluate(() => {
    const { history, stage } = Reflect.get(globalThis, 'clangor');
    return history.contacts.map((/** @type {any} */ contact) => [
      stage.nameOf(contact.bodyA),
      contact.speed,
      contact.duration > 1e-3,
    ]);
  });
  assert.deepEqual(logged, [
    ['wineglass', 0.4, false],
    ['plate', 1.5, true],
  ]);
  await checkLog(page);
  assert.deepEqual(complaints, []);
  await page.close();
}

// Each scene with one of the gestures, another one in each browser, or with EVERY_GESTURE=1 with all of them.
const names = Object.keys(GESTURES);
for (const [shift, browser] of BROWSERS.entries()) {
  const missing = browser === 'firefox' ? missingForFirefox() : null;
  if (missing) console.log(`skipped: ${missing}`);
  describe(`the first gesture in ${browser}`, { skip: missing ?? false }, () => {
    before(async () => {
      session = await openBrowser({
        browser,
        autoplay: false,
        context: { viewport: { width: 480, height: 400 }, hasTouch: true },
      });
    });
    after(() => session?.close());

    for (const [turn, name] of names.entries()) {
      const scenes = SCENES.filter(
        (_, index) => process.env.EVERY_GESTURE || (index + shift) % names.length === turn,
      );
      test(`is heard and logged: ${name}`, { timeout: LONGEST }, async () => {
        for (const scene of scenes) await tryFirst(scene, name);
      });
    }
    test(
      'two taps before the sound runs are two impacts, each logged with its own values',
      { timeout: LONGEST },
      tryTwoTaps,
    );
  });
}
