// The picture of the world at one moment. Its resolution adapts to the frame rate, because sound has
// priority.

import { ArrowHelper, Color, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from 'three';
import { BallsPicture } from './balls-picture.js';
import { POSE_STRIDE } from './event-layout.js';
import { LinksPicture } from './links-picture.js';
import { ListenersPicture } from './listeners-picture.js';
import { OrbitCamera } from './orbit-camera.js';
import { PlanesPicture } from './planes-picture.js';
import { loudness, RIPPLE_TIME, RipplesPicture } from './ripples-picture.js';
import { SolidsPicture } from './solids-picture.js';

const ACCENT = new Color('#f2b15c');
const BACKGROUND = new Color('#0d1015');

/** Number of frames over which the frame time is averaged. */
const FRAMES_PER_DECISION = 40;

/** Frame times [ms]: above the first, the resolution decreases; below the second, it increases. */
const TOO_SLOW = 30;
const FAST = 19;

export class Picture {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {HTMLElement} overlay
   */
  constructor(canvas, overlay) {
    this.canvas = canvas;
    const software = drawsInSoftware();
    this.renderer = new WebGLRenderer({ canvas, antialias: !software, powerPreference: 'high-performance' });
    this.scene = new Scene();
    this.scene.background = BACKGROUND;
    this.view = new OrbitCamera();
    this.balls = new BallsPicture(ACCENT);
    this.planes = new PlanesPicture();
    this.links = new LinksPicture();
    this.ripples = new RipplesPicture(ACCENT);
    this.solids = new SolidsPicture(ACCENT);
    this.listeners = new ListenersPicture(ACCENT, overlay);
    this.arrow = new ArrowHelper(new Vector3(0, 1, 0), new Vector3(), 1, ACCENT);
    this.arrow.visible = false;
    this.scene.add(
      this.planes.group,
      this.balls.group,
      this.links.group,
      this.solids.shadows,
      this.solids.group,
      this.ripples.mesh,
      this.listeners.group,
      this.arrow,
    );
    this.ray = new Raycaster();
    this.poses = new Float32Array(0);
    this.known = 0;
    /** @type {import('./world.js').Body[]} */
    this.bodies = [];
    /** Size of the scene [m]. */
    this.scale = 1;
    /** Corners of its floor [m].
     * @type {number[][]} */
    this.corners = [];
    /** Covered areas at the edges of the canvas [CSS pixels]. */
    this.covered = { top: 0, right: 0, bottom: 0, left: 0 };
    this.calm = matchMedia('(prefers-reduced-motion: reduce)');
    this.sharpness = software ? 0.8 : 1;
    /** @type {number[]} */
    this.durations = [];
    this.frames = 0;
    this.lastDraw = performance.now();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  /** Begins with another view of the scene. @param {import('./orbit-camera.js').View} view */
  look(view) {
    this.view.set(view);
    this.frame();
  }

  /** Fits the scene into the free part of the window. */
  frame() {
    const { clientWidth, clientHeight } = this.canvas;
    this.view.resize(clientWidth, clientHeight, this.covered, this.corners);
  }

  /** @param {{ top: number, right: number, bottom: number, left: number }} covered */
  cover(covered) {
    this.covered = covered;
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * this.sharpness);
    this.renderer.setSize(width, height, false);
    this.frame();
  }

  /**
   * @param {import('./world.js').World} world
   * @param {import('./planes-picture.js').Extent} extent
   */
  setBodies(world, extent) {
    this.bodies = world.bodies;
    this.scale = new Vector3(...extent.low).distanceTo(new Vector3(...extent.high));
    const [[left, ground, back], [right, , front]] = [extent.low, extent.high];
    this.corners = [left, right].flatMap((x) => [back, front].map((z) => [x, ground, z]));
    this.frame();
    this.poses = new Float32Array(world.bodies.length * POSE_STRIDE);
    this.planes.setBodies(world.bodies, world.materials, extent);
    this.balls.uniforms.floorHeight.value = Math.max(-1e5, this.planes.floorHeight);
    this.balls.setBodies(world.bodies, world.materials);
    this.links.setLinks(world.links, world.bodies);
  }

  /**
   * @param {import('./history.js').History} history
   * @param {number} time audible world time [s]
   * @param {import('./listeners.js').Listeners} listeners
   */
  draw(history, time, listeners) {
    // First, because resizing clears the canvas.
    this.adapt();
    this.known = history.poses(time, this.poses);
    const contacts = this.calm.matches ? [] : history.contactsBetween(time - RIPPLE_TIME, time);
    const glow = new Map();
    for (const contact of contacts) {
      const strength = loudness(contact) * Math.exp(-(time - contact.time) / 0.09);
      for (const body of [contact.bodyA, contact.bodyB]) {
        glow.set(body, Math.min(1, (glow.get(body) ?? 0) + strength));
      }
    }
    this.balls.update(this.poses, this.known, glow);
    this.links.update(this.poses, this.known);
    this.solids.update(glow, this.poses, time);
    this.ripples.update(contacts, time, this.scale);
    const { clientWidth, clientHeight } = this.canvas;
    this.listeners.update(listeners, this.view.camera, clientWidth, clientHeight, this.covered);
    this.renderer.render(this.scene, this.view.camera);
  }

  adapt() {
    const now = performance.now();
    const duration = now - this.lastDraw;
    this.lastDraw = now;
    this.frames += 1;
    // Long gaps come from hidden tabs and are not frame times.
    if (duration > 500) return;
    this.durations.push(duration);
    if (this.durations.length < FRAMES_PER_DECISION) return;
    const middle = this.durations.sort((a, b) => a - b)[FRAMES_PER_DECISION >> 1];
    this.durations = [];
    const old = this.sharpness;
    if (middle > TOO_SLOW) this.sharpness = Math.max(0.5, this.sharpness * 0.8);
    else if (middle < FAST) this.sharpness = Math.min(1, this.sharpness * 1.1);
    if (this.sharpness !== old) this.resize();
  }

  /**
   * Aims the ray at a point of the window.
   * @param {number} x @param {number} y both in CSS pixels of the canvas
   */
  aim(x, y) {
    const { clientWidth, clientHeight } = this.canvas;
    const at = new Vector2((2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight);
    this.ray.setFromCamera(at, this.view.camera);
  }

  /**
   * The free ball under a point of the window.
   * @param {number} x @param {number} y
   * @param {number} slack tolerance [CSS pixels]
   * @returns {{ body: number, place: Vector3 } | null}
   */
  ballAt(x, y, slack) {
    this.aim(x, y);
    const { origin, direction } = this.ray.ray;
    const perPixel = (2 * Math.tan((this.view.camera.fov * Math.PI) / 360)) / this.canvas.clientHeight;
    let nearest = Infinity;
    let found = null;
    for (let body = 0; body < this.known; body += 1) {
      const { radius, free, plane } = this.bodies[body];
      if (!free || plane || radius <= 0) continue;
      const place = new Vector3().fromArray(this.poses, body * POSE_STRIDE);
      const along = place.clone().sub(origin).dot(direction);
      if (along <= 0 || along > nearest) continue;
      const miss = place.clone().sub(origin).addScaledVector(direction, -along).length();
      if (miss > radius + slack * perPixel * along) continue;
      nearest = along;
      found = { body, place };
    }
    return found;
  }

  /**
   * Projects a point of the window onto the plane through `through` that faces the camera.
   * @param {number} x @param {number} y
   * @param {Vector3} through
   */
  pointFacing(x, y, through) {
    this.aim(x, y);
    const { origin, direction } = this.ray.ray;
    const ahead = this.view.ahead();
    const away = through.clone().sub(origin).dot(ahead) / direction.dot(ahead);
    return origin.clone().addScaledVector(direction, away);
  }

  /** @param {Vector3} from @param {Vector3} to */
  showArrow(from, to) {
    const along = to.clone().sub(from);
    const length = along.length();
    this.arrow.visible = length > 1e-6;
    if (!this.arrow.visible) return;
    this.arrow.position.copy(from);
    this.arrow.setDirection(along.divideScalar(length));
    const head = Math.min(0.3 * length, 0.04 * this.scale);
    this.arrow.setLength(length, head, 0.5 * head);
  }

  hideArrow() {
    this.arrow.visible = false;
  }
}

/** Whether rendering is in software; antialiasing is then too slow. */
function drawsInSoftware() {
  const context = document.createElement('canvas').getContext('webgl2');
  const names = context?.getExtension('WEBGL_debug_renderer_info');
  const name = names ? context.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
