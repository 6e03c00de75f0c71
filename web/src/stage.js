// The current scene with its settings, and the actions on it. Uses the world, the sound and the history, but
// neither the picture nor the controls.

import { EVENT, EVENT_STRIDE } from './event-layout.js';
import { readContact } from './history.js';
import { Refusal } from './messages.js';
import { readSolid } from './model-file.js';
import { randomNumbers } from './rain.js';
import { inRoom } from './room.js';
import { restingPose } from './strike.js';
import { ModuleError } from './wasm-instance.js';

/** Velocity of a throw without direction [m/s]. */
const TOSS = 2.4;

/** Distance of a new ball's centre from walls, in radii. */
const CLEARANCE = 1.2;

/** Keys of objects beside the bodies of a world go down from here; −1 is the world itself. */
const FIRST_KEY = -2;

export class Stage extends EventTarget {
  /**
   * @param {import('./world.js').World} world
   * @param {import('./sound.js').Sound} sound
   * @param {import('./history.js').History} history
   * @param {import('./transport.js').Transport} transport
   * @param {import('./strike.js').Strikes} strikes
   */
  constructor(world, sound, history, transport, strikes) {
    super();
    this.world = world;
    this.sound = sound;
    this.history = history;
    this.transport = transport;
    this.strikes = strikes;
    /** @type {import('./presets.js').Preset} */
    this.preset = /** @type {any} */ (null);
    /** @type {import('./sphere-box.js').BoxSettings} */
    this.box = { material: 'mixed', walls: 'granite', radius: 0.012, count: 50, gravity: true };
    /** The ball dropped next. */
    this.drop = { material: 'steel', radius: 0.01 };
    this.gravityOn = true;
    /** @type {keyof typeof import('./strike.js').MALLETS} */
    this.mallet = 'wood';
    /** [m/s] */
    this.strikeSpeed = 0.5;
    /** @type {import('./strike.js').PlacedSolid[]} */
    this.objects = [];
    /** Impacts of the page whose time the worklet has not reported yet, by number.
     * @type {Map<number, Float64Array>} */
    this.impacts = new Map();
    this.lastImpact = 0;
    /** Impacts whose time on the clock of the world is not known yet.
     * @type {{ events: Float64Array, contact: Float64Array }[]} */
    this.unplaced = [];
    /** Whether the scene with all its objects is there. */
    this.ready = false;
    /** Actions on this scene: drops, throws, strikes. */
    this.actions = 0;
    /** @type {Map<string, Promise<Uint8Array>>} */
    this.files = new Map();
    this.random = randomNumbers(7);
    world.addEventListener('loaded', () => this.startRain());
    world.addEventListener('frame', (event) => {
      const frame = /** @type {CustomEvent<import('./world.js').Frame>} */ (event).detail;
      transport.follow(frame);
      history.add(frame);
      this.placeImpacts(frame);
    });
    sound.addEventListener('impacts', (event) => {
      const { id, events } = /** @type {CustomEvent} */ (event).detail;
      const contact = this.impacts.get(id);
      // Impacts of the last scene are unknown.
      if (!contact) return;
      this.impacts.delete(id);
      this.unplaced.push({ events, contact });
    });
  }

  /**
   * Whether the scene moves before the sound is on. One that comes to rest by itself waits, so that nothing
   * of it is lost; one in which balls keep falling shows what the page does.
   */
  get movesUnheard() {
    return this.preset.rain !== undefined || this.sound.refused;
  }

  /** @param {import('./presets.js').Preset} preset */
  async load(preset) {
    this.preset = preset;
    this.drop = { material: preset.drop.material, radius: preset.drop.radius };
    this.gravityOn = preset.id === 'box' ? this.box.gravity : true;
    await this.again();
  }

  /** The same scene from its beginning. */
  async again() {
    const { preset } = this;
    if (preset.run) {
      this.replayRun(preset.run);
      return;
    }
    const text = preset.scene(this.box);
    this.transport.reset(false);
    this.history.clear();
    this.forgetImpacts();
    const objects = await this.loadObjects(preset.objects ?? []);
    // Another scene was selected while the files were loading.
    if (preset !== this.preset) return;
    this.objects = objects;
    this.sound.scene(inRoom(text, preset.extent(this.box)));
    this.sound.set({ kind: 'events', events: joined(objects.map(restingPose)) });
    this.world.load(text);
    this.ready = true;
    this.dispatchEvent(new Event('scene'));
  }

  forgetImpacts() {
    this.impacts.clear();
    this.unplaced = [];
    this.ready = false;
    this.actions = 0;
  }

  /** @param {import('./exported-run.js').ExportedRun} run */
  replayRun(run) {
    this.transport.reset(true);
    this.forgetImpacts();
    this.sound.scene(run.about.scene);
    for (const { slot, bytes, damping } of run.models) this.sound.load(slot, bytes, damping);
    this.objects = run.solids;
    this.history.fill(run.frames, run.contacts, run.events);
    this.world.show(run.bodies, run.materials);
    this.dispatchEvent(new Event('scene'));
    this.transport.play();
  }

  /** @param {{ model: string, position: number[] }[]} placed */
  loadObjects(placed) {
    return Promise.all(
      placed.map(async ({ model, position }, slot) => {
        const bytes = await this.file(`models/${model}.safetensors`);
        this.sound.load(slot, bytes);
        this.strikes.load(slot, bytes);
        const solid = readSolid(bytes);
        const [x, y, z] = position;
        return { solid, slot, key: FIRST_KEY - slot, position: [x, y - solid.lowest, z] };
      }),
    );
  }

  /** @param {string} path */
  file(path) {
    let content = this.files.get(path);
    if (!content) {
      content = fetch(new URL(path, document.baseURI)).then(async (response) => {
        if (!response.ok) {
          // The next attempt asks again.
          this.files.delete(path);
          const [name] = /[^/]+$/.exec(path) ?? [path];
          throw new Refusal(`${name} could not be loaded: the server answers ${response.status}`);
        }
        return new Uint8Array(await response.arrayBuffer());
      });
      this.files.set(path, content);
    }
    return content;
  }

  startRain() {
    const plan = this.preset.rain;
    if (!plan) return;
    const materials = plan.materials.map((name) => this.materialIndex(name));
    this.world.rain({ ...plan, materials });
  }

  /** @param {string} name */
  materialIndex(name) {
    return Math.max(
      0,
      this.world.materials.findIndex((material) => material.name === name),
    );
  }

  /** Drops a ball as near to a place as the scene allows. @param {number[]} place [m] */
  dropAt(place) {
    // Loaded objects are not bodies of the world: balls would fall through them.
    if (this.transport.finished || this.objects.length > 0) return;
    this.transport.goLive();
    this.actions += 1;
    const { radius } = this.drop;
    const { low, high } = this.preset.extent(this.box);
    const room = CLEARANCE * radius;
    const [x, y, z] = place.map((value, axis) => {
      const most = axis === 1 ? this.ceiling() : Math.max(low[axis] + room, high[axis] - room);
      return Math.min(most, Math.max(low[axis] + room, value));
    });
    this.world.add(this.materialIndex(this.drop.material), radius, [x, y, z], [0, 0, 0]);
  }

  /** Drops a ball somewhere above the scene; where there are objects, strikes one. */
  dropSomewhere() {
    if (this.objects.length > 0) {
      this.strikeSomething();
      return;
    }
    const { low, high } = this.preset.extent(this.box);
    const inside = (/** @type {number} */ axis) => {
      const room = Math.max(0, (high[axis] - low[axis]) / 2 - 2 * this.drop.radius);
      return (low[axis] + high[axis]) / 2 + room * (this.random() - 0.5);
    };
    const height = Math.min(low[1] + this.preset.drop.height, this.ceiling());
    this.dropAt([inside(0), height, inside(2)]);
  }

  /** Largest height of a ball in a closed scene [m]. */
  ceiling() {
    const lid = this.world.bodies.find((body) => body.plane && body.normal[1] < -0.999);
    return lid ? -lid.distance - CLEARANCE * this.drop.radius : Infinity;
  }

  /** @param {number} body @param {number[]} velocity [m/s] */
  throwBall(body, velocity) {
    this.transport.goLive();
    this.actions += 1;
    this.world.throw(body, velocity);
  }

  /** Throws a random ball upwards. */
  throwSomething() {
    const free = this.world.bodies.flatMap((body, index) => (body.free && body.radius > 0 ? [index] : []));
    if (free.length === 0) return;
    const body = free[Math.floor(this.random() * free.length)];
    const aside = () => 0.5 * TOSS * (this.random() - 0.5);
    this.throwBall(body, [aside(), TOSS, aside()]);
  }

  /** @param {boolean} on */
  gravity(on) {
    this.gravityOn = on;
    this.box.gravity = on;
    this.world.gravity([0, on ? -9.80665 : 0, 0]);
  }

  /**
   * @param {import('./strike.js').PlacedSolid} object
   * @param {number[]} point [m]
   */
  strike(object, point) {
    if (this.transport.finished) return;
    this.transport.goLive();
    try {
      const { events, contact } = this.strikes.impact(object, point, this.strikeSpeed, this.mallet);
      this.actions += 1;
      this.lastImpact += 1;
      this.impacts.set(this.lastImpact, contact);
      this.sound.strike(this.lastImpact, events);
    } catch (error) {
      if (!(error instanceof ModuleError)) throw error;
      this.dispatchEvent(new CustomEvent('failed', { detail: error.message }));
    }
  }

  /** Strikes a random object at a random point. */
  strikeSomething() {
    if (this.objects.length === 0) return;
    const object = this.objects[Math.floor(this.random() * this.objects.length)];
    const { vertices, triangles } = object.solid;
    const at = 3 * Math.floor((this.random() * triangles.length) / 3);
    const [a, b, c] = [0, 1, 2].map((corner) => {
      const vertex = 3 * triangles[at + corner];
      return [...vertices.subarray(vertex, vertex + 3)];
    });
    const point = a.map((x, axis) => (x + b[axis] + c[axis]) / 3 + object.position[axis]);
    this.strike(object, point);
  }

  /**
   * Puts impacts of the page on the clock of the world, for replay and for the log.
   * @param {import('./world.js').Frame} frame whose offset holds up to its time
   */
  placeImpacts({ time: reached, offset, driver }) {
    if (driver !== 'sound' || offset === null) return;
    const later = [];
    for (const impact of this.unplaced) {
      // An impact in the gesture that starts the sound comes before the first step of the world.
      const time = Math.max(0, impact.events[EVENT.time] - offset);
      if (time > reached) later.push(impact);
      else this.remember(impact, time);
    }
    this.unplaced = later;
  }

  /**
   * @param {{ events: Float64Array, contact: Float64Array }} impact
   * @param {number} time of the world [s]
   */
  remember({ events, contact: row }, time) {
    for (let at = 0; at < events.length; at += EVENT_STRIDE) {
      const event = events.slice(at, at + EVENT_STRIDE);
      event[EVENT.time] = time;
      this.history.addEvent(event);
    }
    const contact = readContact(row, 0);
    this.history.addContact({ ...contact, time, bodyA: FIRST_KEY - contact.bodyA });
  }

  /** The name of a body in the log. @param {number} index */
  nameOf(index) {
    if (this.preset.run) return this.preset.run.about.bodies[index]?.name ?? 'ground';
    if (index <= FIRST_KEY) return this.objects[FIRST_KEY - index]?.solid.name ?? '';
    const body = this.world.bodies[index];
    if (!body) return 'ground';
    const material = this.world.materials[body.material]?.name ?? '';
    if (body.plane) return material;
    return `${material} ${index + 1}`;
  }
}

/** @param {Float64Array[]} rows */
function joined(rows) {
  const whole = new Float64Array(rows.length * EVENT_STRIDE);
  rows.forEach((row, index) => whole.set(row, index * EVENT_STRIDE));
  return whole;
}
