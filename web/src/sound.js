// The page's interface to the audio thread: starts it at the first gesture, tracks the audible time, and
// receives levels. The graph: worklet → volume → speakers, and → analyser for the
// spectrogram.

/** @typedef {{ left: number[], right: number[] }} Ears two points [m] */

/**
 * @typedef {object} Report
 * @property {number} time [s]
 * @property {number} peak [Pa]
 * @property {number} rootMeanSquare [Pa]
 * @property {number} load share of real time that the audio thread needs
 * @property {number} dropped events that did not fit or had no time
 * @property {number} failures
 * @property {Float64Array} synth counts of the synthesis
 */

/** Loaded sound models by slot. @typedef {Map<number, Uint8Array>} Models */

/** Output buffer requested [s]: twice the shortest, which avoids gaps on a busy computer. */
const BUFFER = 0.02;

/** Whether a read of the output's latency can hang the page for good: Firefox asks PulseAudio, which waits
 * for the audio thread, which waits for the reader. */
const LATENCY_HANGS = /Linux.*Firefox/.test(globalThis.navigator?.userAgent);

/** Output latency where it is not read [s]: that of Firefox with PulseAudio's null sink. */
const USUAL_LATENCY = 0.045;

/** Impacts that wait for the audio thread, at most; a visitor taps less often while it starts. */
const MOST_WAITING = 64;

export class Sound extends EventTarget {
  /** @param {WebAssembly.Module} module */
  constructor(module) {
    super();
    this.module = module;
    /** @type {AudioContext | null} */
    this.context = null;
    /** @type {AudioWorkletNode | null} */
    this.node = null;
    /** The graph in the making.
     * @type {Promise<void> | null} */
    this.built = null;
    /** @type {AnalyserNode | null} */
    this.analyser = null;
    /** @type {GainNode | null} */
    this.volume = null;
    this.muted = false;
    /** From the time of an event to its first sample at the source [s]. */
    this.latency = 0;
    /** Messages that a worklet needs when it starts, by kind.
     * @type {Map<string, any>} */
    this.settings = new Map();
    /** Impacts of the page before the audio thread is there, in their order.
     * @type {any[]} */
    this.waiting = [];
    /** From the gesture that starts the sound until it runs. */
    this.starting = false;
    /** Whether the last start failed. */
    this.refused = false;
    /** @type {Float32Array[][]} */
    this.recorded = [[], []];
  }

  get on() {
    return this.node !== null && this.context?.state === 'running';
  }

  /**
   * Must be called from a gesture, as browsers require.
   * @param {(port: MessagePort, sampleRate: number) => void} connectWorld gets the port of the ticks
   */
  async start(connectWorld) {
    if (this.on) return;
    if (this.starting) {
      // A later part of the same gesture may be the one that the browser accepts.
      this.context?.resume();
      return;
    }
    this.starting = true;
    try {
      this.context ??= new AudioContext({ latencyHint: BUFFER });
      this.context.onstatechange = () => this.say('state', null);
      const resumed = this.context.resume();
      this.built ??= this.build(this.context, connectWorld);
      await Promise.all([this.built, resumed]);
      this.refused = false;
    } catch (error) {
      this.built = this.node && this.built;
      this.refused = true;
      throw error;
    } finally {
      this.starting = false;
    }
    this.say('on', null);
  }

  /**
   * The graph, once.
   * @param {AudioContext} context
   * @param {(port: MessagePort, sampleRate: number) => void} connectWorld
   */
  async build(context, connectWorld) {
    await context.audioWorklet.addModule(new URL('sound-worklet.js', document.baseURI).href);
    const node = new AudioWorkletNode(context, 'clangor', {
      numberOfInputs: 0,
      outputChannelCount: [2],
      processorOptions: { module: this.module, messages: [...this.settings.values()] },
    });
    node.port.onmessage = (message) => this.receive(message.data);
    node.onprocessorerror = () => this.say('failed', 'the audio thread stopped; reload the page');
    this.analyser = new AnalyserNode(context, { fftSize: 2048, smoothingTimeConstant: 0 });
    this.volume = new GainNode(context, { gain: this.muted ? 0 : 1 });
    node.connect(this.volume).connect(context.destination);
    node.connect(this.analyser);
    this.node = node;
    const channel = new MessageChannel();
    node.port.postMessage({ kind: 'world', port: channel.port1 }, [channel.port1]);
    connectWorld(channel.port2, context.sampleRate);
    for (const message of this.waiting.splice(0)) node.port.postMessage(message);
  }

  /** Mutes the output; synthesis and recording continue. @param {boolean} muted */
  mute(muted) {
    this.muted = muted;
    if (this.context && this.volume) {
      this.volume.gain.setTargetAtTime(muted ? 0 : 1, this.context.currentTime, 0.01);
    }
  }

  /** @param {string} type @param {any} detail */
  say(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  /** @param {any} message */
  receive(message) {
    switch (message.kind) {
      case 'started':
        this.latency = message.latency;
        break;
      case 'recording':
        this.recorded[0].push(message.left);
        this.recorded[1].push(message.right);
        break;
    }
    this.say(message.kind, message.kind === 'failed' ? message.message : message);
  }

  /**
   * Sends a setting, now or when the worklet starts; the last of each kind (and slot) is kept.
   * @param {any} message
   */
  set(message) {
    this.settings.set(`${message.kind} ${message.slot ?? ''}`, message);
    this.node?.port.postMessage(message);
  }

  /**
   * Sends a message, if the audio thread is there. @param {any} message @param {Transferable[]} [transfer]
   */
  post(message, transfer = []) {
    this.node?.port.postMessage(message, transfer);
  }

  /**
   * An impact of the page, heard as soon as possible. Before the sound runs, it waits.
   * @param {number} id comes back with the time of the impact
   * @param {Float64Array} events rows of `EVENT_STRIDE`
   */
  strike(id, events) {
    const message = { kind: 'strike', id, events };
    if (this.node) this.node.port.postMessage(message);
    else if (this.waiting.length < MOST_WAITING) this.waiting.push(message);
  }

  /** Medium, room and floor for the sound. @param {string} text of a scene */
  scene(text) {
    this.waiting = [];
    this.set({ kind: 'scene', bytes: new TextEncoder().encode(text) });
  }

  /**
   * @param {number} slot
   * @param {Uint8Array} bytes of a sound model
   * @param {string} damping pairs of frequency [Hz] and T60 [s] as JSON; empty: that of the named material
   */
  load(slot, bytes, damping = '') {
    const tail = new TextEncoder().encode(damping);
    const whole = new Uint8Array(bytes.length + tail.length);
    whole.set(bytes);
    whole.set(tail, bytes.length);
    this.set({ kind: 'load', slot, bytes: whole, dampingLength: tail.length });
  }

  /** @param {Ears} ears */
  listener({ left, right }) {
    this.set({ kind: 'listener', left, right });
  }

  /** @param {number} pascals at full scale */
  gain(pascals) {
    this.set({ kind: 'gain', pascals });
  }

  /** @param {boolean} on */
  reflections(on) {
    this.set({ kind: 'reflections', on });
  }

  /**
   * The audible time of the context [s], from the browser's output timestamp where it may be read.
   */
  audibleTime() {
    const { context } = this;
    if (!context) return 0;
    if (LATENCY_HANGS) return context.currentTime - USUAL_LATENCY;
    const stamp = context.getOutputTimestamp();
    const now = performance.now();
    if (stamp.contextTime && stamp.performanceTime && now - stamp.performanceTime < 500) {
      const time = stamp.contextTime + (now - stamp.performanceTime) / 1000;
      // Some browsers return a timestamp ahead of the rendered time.
      if (time > 0 && time <= context.currentTime + 0.05) return time;
    }
    return context.currentTime - (context.outputLatency || context.baseLatency || 0);
  }
}
