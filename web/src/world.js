// The page's interface to the world's thread: commands and results.

/**
 * @typedef {object} Body
 * @property {number} radius [m]
 * @property {number} material index
 * @property {boolean} free
 * @property {boolean} plane
 * @property {number[]} normal of a plane
 * @property {number} distance of a plane from the origin along its normal [m]
 */

/**
 * @typedef {object} Link
 * @property {'rod' | 'spring'} kind
 * @property {number} body
 * @property {number} other body, or −1
 * @property {number[]} anchor [m], if there is no other body
 */

/**
 * @typedef {object} Frame
 * @property {number} time of the world [s]
 * @property {number | null} offset time of the driver's clock minus time of the world [s]
 * @property {'page' | 'sound'} driver
 * @property {number} skips number of time skips
 * @property {Float32Array} poses
 * @property {Float64Array} contacts
 * @property {Float64Array} events
 */

export class World extends EventTarget {
  /** @param {WebAssembly.Module} module */
  constructor(module) {
    super();
    this.generation = 0;
    /** @type {Body[]} */
    this.bodies = [];
    /** @type {Link[]} */
    this.links = [];
    /** @type {{ name: string }[]} */
    this.materials = [];
    this.solver = 0;
    this.worker = new Worker(new URL('world-worker.js', document.baseURI), { type: 'module' });
    this.worker.onmessage = (message) => this.receive(message.data);
    this.worker.onerror = () => this.say('failed', 'the simulation stopped; reload the page');
    this.worker.postMessage({ kind: 'start', module });
  }

  /** @param {string} type @param {any} detail */
  say(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  /** @param {any} message */
  receive(message) {
    // Messages of the last scene are ignored.
    if (message.generation !== this.generation) return;
    switch (message.kind) {
      case 'loaded':
        this.materials = message.materials;
        this.solver = message.solver;
        break;
      case 'bodies':
        this.bodies = readBodies(message.bodies);
        this.links = readLinks(message.links);
        this.say('bodies', this.bodies);
        return;
      case 'failed':
        this.say('failed', message.message);
        return;
    }
    this.say(message.kind, message);
  }

  /**
   * @param {string} text of a scene
   * @param {import('./rain.js').RainSettings | null} [rain]
   */
  load(text, rain = null) {
    this.generation += 1;
    this.worker.postMessage({ kind: 'load', text, rain, generation: this.generation });
  }

  /**
   * Stops the simulation and shows bodies that another part of the page moves.
   * @param {Body[]} bodies
   * @param {{ name: string }[]} materials
   */
  show(bodies, materials) {
    this.generation += 1;
    this.run(false);
    this.bodies = bodies;
    this.links = [];
    this.materials = materials;
    this.say('bodies', bodies);
  }

  /** @param {MessagePort} port to the worklet @param {number} sampleRate */
  connect(port, sampleRate) {
    this.worker.postMessage({ kind: 'connect', port, sampleRate }, [port]);
  }

  /** Without sound, time comes from the page. @param {number} time [s] */
  tick(time) {
    this.worker.postMessage({ kind: 'tick', time });
  }

  /** @param {boolean} on */
  run(on) {
    this.worker.postMessage({ kind: 'run', on });
  }

  /** @param {number} body @param {number[]} velocity [m/s] */
  throw(body, velocity) {
    this.worker.postMessage({ kind: 'throw', body, velocity });
  }

  /**
   * @param {number} material index
   * @param {number} radius [m]
   * @param {number[]} position [m]
   * @param {number[]} velocity [m/s]
   */
  add(material, radius, position, velocity) {
    this.worker.postMessage({ kind: 'add', material, radius, position, velocity });
  }

  /** @param {number[]} vector [m/s²] */
  gravity(vector) {
    this.worker.postMessage({ kind: 'gravity', vector });
  }

  /** @param {import('./rain.js').RainSettings | null} settings */
  rain(settings) {
    this.worker.postMessage({ kind: 'rain', settings });
  }
}

/** @param {Float64Array} rows @returns {Body[]} */
function readBodies(rows) {
  const bodies = [];
  for (let at = 0; at < rows.length; at += 8) {
    bodies.push({
      radius: rows[at],
      material: rows[at + 1],
      free: rows[at + 2] !== 0,
      plane: rows[at + 3] !== 0,
      normal: [rows[at + 4], rows[at + 5], rows[at + 6]],
      distance: rows[at + 7],
    });
  }
  return bodies;
}

/** @param {Float64Array} rows @returns {Link[]} */
function readLinks(rows) {
  /** @type {Link[]} */
  const links = [];
  for (let at = 0; at < rows.length; at += 8) {
    links.push({
      kind: rows[at] === 0 ? 'rod' : 'spring',
      body: rows[at + 1],
      other: rows[at + 2],
      anchor: [rows[at + 3], rows[at + 4], rows[at + 5]],
    });
  }
  return links;
}
