// A WAV file of 32-bit floats, two channels (docs/format/audio.md): the samples are the pressure in pascals.

/** Bytes before the samples: RIFF header, fmt with the empty extension of floats, fact, data header. */
const HEADER = 12 + 26 + 12 + 8;

/** IEEE float. */
const FORMAT = 3;

/**
 * @param {Float32Array[]} left chunks
 * @param {Float32Array[]} right chunks of the same lengths
 * @param {number} sampleRate
 * @returns {Uint8Array<ArrayBuffer>}
 */
export function wavFile(left, right, sampleRate) {
  const frames = left.reduce((sum, chunk) => sum + chunk.length, 0);
  const bytes = new Uint8Array(HEADER + 8 * frames);
  const view = new DataView(bytes.buffer);
  let at = 0;
  const text = (/** @type {string} */ letters) => {
    for (const letter of letters) view.setUint8(at++, letter.charCodeAt(0));
  };
  const short = (/** @type {number} */ number) => {
    view.setUint16(at, number, true);
    at += 2;
  };
  const long = (/** @type {number} */ number) => {
    view.setUint32(at, number, true);
    at += 4;
  };
  text('RIFF');
  long(bytes.length - 8);
  text('WAVEfmt ');
  long(18);
  short(FORMAT);
  short(2);
  long(sampleRate);
  long(8 * sampleRate);
  short(8);
  short(32);
  short(0);
  text('fact');
  long(4);
  long(frames);
  text('data');
  long(8 * frames);
  left.forEach((chunk, index) => {
    for (let i = 0; i < chunk.length; i += 1) {
      view.setFloat32(at, chunk[i], true);
      view.setFloat32(at + 4, right[index][i], true);
      at += 8;
    }
  });
  return bytes;
}
