// Spectrogram of the output in real time: time from right to left, octaves upwards.

/** Ranges shown: frequency [Hz] and level [dB re full scale]. */
const LOWEST = 60;
const HIGHEST = 20000;
const QUIETEST = -110;
const LOUDEST = -20;

/** Columns per second, independent of the frame rate. */
const SPEED = 60;

/** Labelled frequencies [Hz]. */
const MARKS = [100, 1000, 10000];

export class Spectrogram {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d'));
    this.bins = new Float32Array(1024);
    this.drawnUntil = 0;
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.canvas.width = clientWidth;
    this.canvas.height = clientHeight;
    this.context.fillStyle = `rgb(${STOPS[0].join(' ')})`;
    this.context.fillRect(0, 0, clientWidth, clientHeight);
    this.column = this.context.createImageData(1, clientHeight);
  }

  /** @param {AnalyserNode} analyser */
  draw(analyser) {
    const { canvas, context, column, bins } = this;
    const now = analyser.context.currentTime * SPEED;
    const columns = Math.min(SPEED, Math.floor(now - this.drawnUntil));
    if (!column || columns < 1) return;
    this.drawnUntil = Math.floor(now);
    analyser.getFloatFrequencyData(bins);
    const perBin = analyser.context.sampleRate / analyser.fftSize;
    const { height, width } = canvas;
    const pixels = column.data;
    for (let row = 0; row < height; row += 1) {
      const low = frequencyAt(row + 1, height) / perBin;
      const high = frequencyAt(row, height) / perBin;
      // Several bins in one pixel: the loudest. Several pixels in one bin: between its neighbours.
      let level = mix(bins, (low + high) / 2);
      for (let bin = Math.ceil(low); bin < high && bin < bins.length; bin += 1) {
        level = Math.max(level, bins[bin]);
      }
      const part = Math.min(1, Math.max(0, (level - QUIETEST) / (LOUDEST - QUIETEST)));
      const colour = RAMP[Math.round(part * 255)];
      pixels.set(colour, 4 * row);
      pixels[4 * row + 3] = 255;
    }
    context.drawImage(canvas, -columns, 0);
    for (let x = width - columns; x < width; x += 1) context.putImageData(column, x, 0);
  }

  /** Positions of the labels, from the top, as parts of the height. */
  static marks() {
    return MARKS.map((frequency) => ({
      text: frequency >= 1000 ? `${frequency / 1000} kHz` : `${frequency} Hz`,
      part: 1 - Math.log(frequency / LOWEST) / Math.log(HIGHEST / LOWEST),
    }));
  }
}

/** @param {number} row @param {number} height */
function frequencyAt(row, height) {
  return LOWEST * (HIGHEST / LOWEST) ** (1 - row / height);
}

/** @param {Float32Array} bins @param {number} at */
function mix(bins, at) {
  const below = Math.min(bins.length - 2, Math.floor(at));
  const part = at - below;
  return Math.max(-200, bins[below]) * (1 - part) + Math.max(-200, bins[below + 1]) * part;
}

/** Dark blue over plum to amber and white, even in lightness. */
const STOPS = [
  [13, 16, 21],
  [28, 32, 58],
  [84, 48, 92],
  [170, 76, 82],
  [242, 177, 92],
  [255, 246, 224],
];

const RAMP = Array.from({ length: 256 }, (_, i) => {
  const at = (i / 255) * (STOPS.length - 1);
  const stop = Math.min(STOPS.length - 2, Math.floor(at));
  return STOPS[stop].map((from, k) => Math.round(from + (STOPS[stop + 1][k] - from) * (at - stop)));
});
