// Pictures of every preset, and of the page on a phone, into web/screenshots: to be looked at.
// `npm run screenshots [-- PRESET …]`

import { mkdir } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { openBrowser } from './browser.mjs';

const FOLDER = fileURLToPath(new URL('../screenshots', import.meta.url));

/** Preset, and how long it runs before the picture is taken [ms]. */
const PRESETS = {
  drops: 7000,
  cradle: 2600,
  pool: 1500,
  trick: 1600,
  pile: 3500,
  sculpture: 2500,
  objects: 1500,
  box: 2500,
};

const asked = process.argv.slice(2);
await mkdir(FOLDER, { recursive: true });

const desk = await openBrowser();
for (const [preset, wait] of Object.entries(PRESETS)) {
  if (asked.length > 0 && !asked.includes(preset)) continue;
  const { page, complaints } = await desk.open(`#${preset}`);
  await page.mouse.click(640, 300);
  if (preset === 'objects') {
    await page.waitForTimeout(700);
    for (const [x, y] of [
      [357, 345],
      [640, 400],
    ]) {
      await page.mouse.click(x, y);
      await page.waitForTimeout(250);
    }
  }
  await page.waitForTimeout(wait);
  await page.screenshot({ path: `${FOLDER}/${preset}.png` });
  console.log(preset, complaints);
  await page.close();
}
if (asked.length === 0 || asked.includes('still')) {
  const { page } = await desk.open();
  await page.waitForTimeout(2500);
  await page.screenshot({ path: `${FOLDER}/still.png` });
  await page.keyboard.press('?');
  await page.waitForTimeout(500);
  await page.screenshot({ path: `${FOLDER}/help.png` });
  await page.close();
}
await desk.close();

if (asked.length === 0 || asked.includes('phone')) {
  const phone = await openBrowser({
    context: {
      viewport: { width: 390, height: 844 },
      deviceScaleFactor: 1,
      hasTouch: true,
      isMobile: true,
    },
  });
  const { page } = await phone.open();
  await page.waitForTimeout(1500);
  await page.screenshot({ path: `${FOLDER}/phone-still.png` });
  await page.touchscreen.tap(195, 400);
  await page.waitForTimeout(2500);
  await page.screenshot({ path: `${FOLDER}/phone.png` });
  await page.tap('#settings-toggle');
  await page.waitForTimeout(300);
  await page.screenshot({ path: `${FOLDER}/phone-settings.png` });
  await phone.close();
}
