// Waits and measures of tests by the audio clock of the page, which runs on however slow the machine is.

/** @typedef {import('playwright-core').Page} Page */

/** A peak above this is heard [Pa]: 34 dB above the threshold of hearing. */
export const HEARD = 1e-3;

/** Longest wait of a test for the page [ms]; by the wall clock, for a page that stands still. */
export const PATIENCE = { timeout: 60000 };

/**
 * Waits until the audio clock has moved by so many seconds.
 * @param {Page} page @param {number} seconds
 */
export async function letSound(page, seconds) {
  await page.evaluate(
    (length) =>
      new Promise((resolve) => {
        const { sound } = Reflect.get(globalThis, 'clangor');
        const end = sound.context.currentTime + length;
        const listen = (/** @type {any} */ event) => {
          if (event.detail.time < end) return;
          sound.removeEventListener('report', listen);
          resolve(undefined);
        };
        sound.addEventListener('report', listen);
      }),
    seconds,
  );
}

/**
 * Waits until the world has reached a time [s].
 * @param {Page} page @param {number} time
 */
export async function letMove(page, time) {
  await page.waitForFunction(
    (until) => Reflect.get(globalThis, 'clangor').history.end >= until,
    time,
    PATIENCE,
  );
}

/**
 * Begins to keep the peaks of the sound and its first audible sample, before the sound is on.
 * @param {Page} page
 */
export async function listen(page) {
  await page.evaluate(() => {
    const { sound, history } = Reflect.get(globalThis, 'clangor');
    const begun = history.end;
    const ear = { peak: 0, reports: 0, time: 0, begun, /** @type {number | null} */ first: null };
    Reflect.set(globalThis, 'ear', ear);
    sound.addEventListener('report', (/** @type {any} */ event) => {
      ear.peak = Math.max(ear.peak, event.detail.peak);
      ear.time = event.detail.time;
      ear.reports += 1;
    });
    sound.addEventListener('first-sound', (/** @type {any} */ event) => (ear.first ??= event.detail.time));
    sound.set({ kind: 'await-sound' });
  });
}

/**
 * What `listen` has kept.
 * @param {Page} page
 * @returns {Promise<{ peak: number, reports: number, time: number, first: number | null }>}
 */
export function heard(page) {
  return page.evaluate(() => Reflect.get(globalThis, 'ear'));
}

/**
 * Waits until something is heard, so many seconds of the audio clock and of the world at most: on a busy
 * machine the world falls behind the sound.
 * @param {Page} page @param {number} seconds
 */
export async function hear(page, seconds) {
  await page.waitForFunction(
    ([least, end]) => {
      const { peak, time, first, begun } = Reflect.get(globalThis, 'ear');
      const { history } = Reflect.get(globalThis, 'clangor');
      return (peak > least && first !== null) || (time > end && history.end > begun + end);
    },
    [HEARD, seconds],
    PATIENCE,
  );
  return heard(page);
}

/**
 * Largest peak of the reports [Pa] within so many seconds of the audio clock, from now on.
 * @param {Page} page @param {number} seconds
 */
export async function loudestWithin(page, seconds) {
  await listen(page);
  await letSound(page, seconds);
  return heard(page);
}
