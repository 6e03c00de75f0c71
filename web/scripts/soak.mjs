// How the page bears 300 balls for a minute: frames per second, gaps in the sound, load of the audio thread,
// how often the world fell behind. `npm run soak [-- SECONDS PRESET BALLS]`; 300 balls without gravity in the
// sphere box by default.

import { openBrowser } from './browser.mjs';

const seconds = Number(process.argv[2] ?? 60);
const preset = process.argv[3] ?? 'box';
const balls = Number(process.argv[4] ?? 300);

const session = await openBrowser();
const { page, complaints } = await session.open(`#${preset}`);
await page.mouse.click(640, 300);
if (preset === 'box') {
  await page.evaluate((count) => {
    const { stage } = Reflect.get(globalThis, 'clangor');
    stage.box = { ...stage.box, count, gravity: false };
    return stage.again();
  }, balls);
}
await page.waitForTimeout(5000);
const result = await page.evaluate(async (length) => {
  const { sound, picture, transport, history, world, stage } = Reflect.get(globalThis, 'clangor');
  const { context } = sound;
  const begin = { frames: picture.frames, audio: context.currentTime, wall: performance.now() };
  const stats = context.playbackStats ?? context.playoutStats;
  const before = stats?.toJSON?.();
  let skips = 0;
  let contacts = 0;
  let dropped = 0;
  const loads = [];
  world.addEventListener('frame', (event) => {
    skips = event.detail.skips;
    contacts += event.detail.contacts.length / 12;
  });
  sound.addEventListener('report', (event) => {
    loads.push(event.detail.load);
    dropped = event.detail.dropped + event.detail.synth[5];
  });
  // Every ten seconds anew: what collides comes to rest.
  for (let left = length; left > 0; left -= 10) {
    await new Promise((done) => setTimeout(done, 1000 * Math.min(10, left)));
    if (left > 10) await stage.again();
  }
  const wall = (performance.now() - begin.wall) / 1000;
  loads.sort((a, b) => a - b);
  return {
    framesPerSecond: (picture.frames - begin.frames) / wall,
    audioSecondsLost: wall - (context.currentTime - begin.audio),
    underruns: stats
      ? stats.toJSON().underrunEvents - before.underrunEvents
      : 'this browser does not count them',
    audioLoadMean: loads.reduce((a, b) => a + b, 0) / loads.length,
    audioLoadWorst: loads[loads.length - 1],
    worldSkips: skips,
    contactsPerSecond: contacts / wall,
    eventsDropped: dropped,
    balls: picture.balls.bodyOf.length,
    sharpness: picture.sharpness,
    mode: transport.mode,
    keptSeconds: history.end - history.start,
  };
}, seconds);
console.log(JSON.stringify(result, null, 2));
if (complaints.length > 0) console.log('complaints:', complaints);
await session.close();
