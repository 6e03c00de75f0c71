// The page on windows from 320 to 2560 pixels, upright and lying, with letters of normal and double size:
// nothing is clipped or covered, what is pressed has 44 pixels, the scene is beside the settings and not
// under them. And what assistive technology needs: names, contrast, an order of focus that follows the
// page.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser } from '../scripts/browser.mjs';
import { PATIENCE } from './audio-clock.mjs';
import { checkContrast, checkNames, checkScene, checkWindow } from './layout-checks.mjs';

const WINDOWS = [
  [320, 568],
  [568, 320],
  [390, 844],
  [844, 390],
  [768, 1024],
  [1024, 768],
  [1280, 800],
  [2560, 1440],
];

/** Size of the letters: the page's own, and twice that. */
const LETTERS = ['', '175%'];

/** Least contrast of text (WCAG 2.2, 1.4.3). */
const CONTRAST = 4.5;

/** @type {Awaited<ReturnType<typeof openBrowser>>} */
let session;
/** @type {import('playwright-core').Page} */
let page;

before(async () => {
  session = await openBrowser({ autoplay: false, context: { hasTouch: true } });
  ({ page } = await session.open('#objects'));
  await page.waitForFunction(() => Reflect.get(globalThis, 'clangor').stage.ready, null, PATIENCE);
  // The picture is not looked at here, and drawing large ones in software takes long.
  await page.evaluate(() => {
    const { picture } = Reflect.get(globalThis, 'clangor');
    picture.renderer.render = () => {};
  });
});
after(() => session?.close());

/** @param {number[]} size @param {string} letters @param {boolean} settings whether they are open */
async function arrange([width, height], letters, settings) {
  await page.setViewportSize({ width, height });
  await page.evaluate(async ([fontSize, shown]) => {
    document.documentElement.style.fontSize = String(fontSize);
    Reflect.get(globalThis, 'clangor').controls.showSettings(shown);
    for (let frame = 0; frame < 3; frame += 1) await new Promise((done) => requestAnimationFrame(done));
  }, /** @type {[string, boolean]} */ ([letters, settings]));
}

for (const letters of LETTERS) {
  test(`nothing is clipped, covered or small, letters ${letters || 'of normal size'}`, async () => {
    /** @type {string[]} */
    const faults = [];
    for (const size of WINDOWS) {
      for (const settings of [false, true]) {
        await arrange(size, letters, settings);
        const found = [...(await page.evaluate(checkWindow)), ...(await page.evaluate(checkScene))];
        faults.push(
          ...found.map((fault) => `${size.join('×')}${settings ? ' with settings' : ''}: ${fault}`),
        );
      }
    }
    assert.equal(faults.join('\n'), '');
  });
}

test('help fits the window, begins at its top, and speaks of fingers where there are no keys', async () => {
  const faults = [];
  for (const letters of LETTERS) {
    for (const size of WINDOWS) {
      await arrange(size, letters, false);
      await page.evaluate(() => Reflect.get(globalThis, 'clangor').controls.explain());
      const found = await page.evaluate(() => {
        const help = /** @type {HTMLDialogElement} */ (document.getElementById('help'));
        const { top, bottom, left, right } = help.getBoundingClientRect();
        const state = {
          inside: top >= 0 && left >= 0 && bottom <= innerHeight && right <= innerWidth,
          narrow: help.scrollWidth <= help.clientWidth,
          atTop: help.scrollTop === 0,
          keys: [...help.querySelectorAll('kbd')].some((key) => key.getClientRects().length > 0),
          fingers: help.innerText.includes('two fingers'),
        };
        help.close();
        return state;
      });
      const good = { inside: true, narrow: true, atTop: true, keys: false, fingers: true };
      if (JSON.stringify(found) !== JSON.stringify(good)) faults.push([size, letters, found]);
    }
  }
  assert.deepEqual(faults, []);
});

test('every control has a name, every text contrast, and the focus goes from top to bottom', async () => {
  await arrange([1280, 800], '', true);
  assert.deepEqual(await page.evaluate(checkNames), []);
  assert.deepEqual(await page.evaluate(checkContrast, CONTRAST), []);
  await page.evaluate(() => Reflect.get(globalThis, 'clangor').controls.explain());
  assert.deepEqual(await page.evaluate(checkContrast, CONTRAST), []);
  await page.keyboard.press('Escape');
  await page.focus('#picture');
  const visited = [];
  for (let step = 0; step < 60; step += 1) {
    await page.keyboard.press('Tab');
    const where = await page.evaluate(() => {
      const { activeElement: element } = document;
      if (!element || element === document.body) return null;
      const area = ['top', 'wake', 'settings', 'dock'].find((id) => element.closest(`#${id}`)) ?? element.id;
      return { area, name: element.id || /** @type {HTMLInputElement} */ (element).name };
    });
    if (where === null || where.area === 'picture') break;
    visited.push(where);
  }
  const areas = visited.map(({ area }) => area).filter((area, i, all) => area !== all[i - 1]);
  assert.deepEqual(
    areas.filter((area) => area !== 'wake'),
    ['top', 'settings', 'dock'],
  );
  const names = new Set(visited.map(({ name }) => name));
  for (const id of [
    'presets',
    'sound',
    'settings-toggle',
    'help-open',
    'strike',
    'again',
    'mallet',
    'listener',
    'play',
    'scrub',
    'live',
  ]) {
    assert.ok(names.has(id), `${id} is reached by Tab`);
  }
});
