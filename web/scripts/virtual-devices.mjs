// A sound device and a screen for a browser that needs them, on a machine that has none. Firefox without a
// sound device leaves its AudioContext suspended, and without a screen it has no WebGL.

import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as pause } from 'node:timers/promises';

export const PULSEAUDIO = '/usr/bin/pulseaudio';
export const XVFB = '/usr/bin/Xvfb';

/** Longest wait for the socket of a device [ms]. */
const PATIENCE = 20000;

/**
 * @param {string} program
 * @param {string[]} parameters
 * @param {import('node:child_process').SpawnOptions} options
 */
function start(program, parameters, options) {
  const daemon = spawn(program, parameters, options);
  const ended = new Promise((done) => daemon.once('close', done).once('error', done));
  return {
    daemon,
    ended,
    async stop() {
      daemon.kill();
      await ended;
    },
  };
}

/**
 * A null sink, which takes sound at the rate of a real device and drops it: a PulseAudio apart from that of
 * the user, if there is one.
 * @returns {Promise<{ server: string, close: () => Promise<void> }>} with the value of PULSE_SERVER
 */
export async function openSink() {
  const folder = await mkdtemp(join(tmpdir(), 'clangor-sink-'));
  const socket = join(folder, 'native');
  const { daemon, stop } = start(
    PULSEAUDIO,
    [
      ...['-n', '--daemonize=no', '--use-pid-file=no', '--exit-idle-time=-1', '--log-level=error'],
      '--load=module-null-sink',
      `--load=module-native-protocol-unix auth-anonymous=1 socket=${socket}`,
    ],
    {
      stdio: ['ignore', 'ignore', 'inherit'],
      env: { ...process.env, HOME: folder, XDG_RUNTIME_DIR: folder },
    },
  );
  const close = async () => {
    await stop();
    await rm(folder, { recursive: true, force: true });
  };
  for (const begun = Date.now(); !existsSync(socket); await pause(20)) {
    if (daemon.exitCode === null && Date.now() - begun < PATIENCE) continue;
    await close();
    throw new Error(`${PULSEAUDIO} opens no socket`);
  }
  return { server: `unix:${socket}`, close };
}

/**
 * A screen in memory, under a number that is free.
 * @returns {Promise<{ display: string, close: () => Promise<void> }>} with the value of DISPLAY
 */
export async function openScreen() {
  const { daemon, ended, stop } = start(
    XVFB,
    ['-displayfd', '3', '-screen', '0', '1920x1200x24', '-nolisten', 'tcp'],
    { stdio: ['ignore', 'ignore', 'ignore', 'pipe'] },
  );
  const number = await Promise.race([
    new Promise((told) => daemon.stdio[3]?.once('data', (text) => told(String(text).trim()))),
    ended.then(() => null),
  ]);
  if (number === null) throw new Error(`${XVFB} opens no screen`);
  return { display: `:${number}`, close: stop };
}
