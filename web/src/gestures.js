// Gestures of mouse, pen and touch on the picture: drag a ball to throw it, drag a listener to move it, tap
// it to listen there, tap an object to strike it, tap the background to drop a ball, drag the background to
// rotate the view, pinch or wheel to zoom.

import { Vector3 } from 'three';

/** Less movement than this is a tap [CSS pixels]. */
const TAP_SLACK = 7;

/** Tolerance around a ball for touch and mouse [CSS pixels]. */
const FINGER_SLACK = 16;
const MOUSE_SLACK = 4;

/** Radius of the head of a listener, for touch and mouse [CSS pixels]. */
const FINGER_HEAD = 24;
const MOUSE_HEAD = 18;

/** Rotation of the view [rad] per pixel of dragging. */
const ORBIT_RATE = 0.006;

/** @typedef {import('./strike.js').PlacedSolid} PlacedSolid */
/** @typedef {{ object: PlacedSolid, point: number[] }} Hit */

/**
 * @typedef {object} Actions
 * @property {(index: number) => void} listenFrom
 * @property {(body: number, velocity: Vector3) => void} throwBall
 * @property {(place: Vector3) => void} drop
 * @property {(hit: Hit) => void} strike
 * @property {(index: number, place: Vector3) => void} moveListener
 * @property {() => number} throwRate metres per second per metre of dragging
 * @property {(text: string, x: number, y: number) => void} tell shows a few words beside the pointer
 */

export class Gestures {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import('./picture.js').Picture} picture
   * @param {import('./listeners.js').Listeners} listeners
   * @param {Actions} actions
   */
  constructor(canvas, picture, listeners, actions) {
    this.canvas = canvas;
    this.picture = picture;
    this.listeners = listeners;
    this.actions = actions;
    /** @type {Map<number, { x: number, y: number }>} */
    this.pointers = new Map();
    /** What the first pointer holds.
     * @type {{ kind: 'ball', body: number, place: Vector3 }
     *   | { kind: 'listener', index: number } | { kind: 'air' } | { kind: 'nothing' }} */
    this.held = { kind: 'nothing' };
    this.moved = 0;
    canvas.addEventListener('pointerdown', (event) => this.down(event));
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerup', (event) => this.up(event));
    canvas.addEventListener('pointercancel', (event) => this.cancel(event));
    canvas.addEventListener(
      'wheel',
      (event) => {
        event.preventDefault();
        picture.view.zoom(Math.exp(0.001 * event.deltaY));
      },
      { passive: false },
    );
  }

  /** @param {PointerEvent} event */
  at(event) {
    const box = this.canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  /** @param {PointerEvent} event */
  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.at(event);
    this.pointers.set(event.pointerId, at);
    if (this.pointers.size > 1) {
      this.letGo();
      this.held = { kind: 'air' };
      this.moved = Infinity;
      return;
    }
    this.moved = 0;
    const mouse = event.pointerType === 'mouse';
    const listener = this.listenerAt(at, mouse ? MOUSE_HEAD : FINGER_HEAD);
    if (listener >= 0) {
      this.held = { kind: 'listener', index: listener };
      return;
    }
    const ball = this.picture.ballAt(at.x, at.y, mouse ? MOUSE_SLACK : FINGER_SLACK);
    if (ball) {
      this.held = { kind: 'ball', ...ball };
      return;
    }
    const hit = this.picture.solids.hit(this.picture.ray);
    if (hit) {
      this.held = { kind: 'nothing' };
      this.actions.strike(hit);
      return;
    }
    this.held = { kind: 'air' };
  }

  /** @param {{ x: number, y: number }} at @param {number} radius [CSS pixels] */
  listenerAt(at, radius) {
    const { clientWidth, clientHeight } = this.canvas;
    return this.listeners.places.findIndex((place) => {
      const seen = place.clone().project(this.picture.view.camera);
      const x = (0.5 + 0.5 * seen.x) * clientWidth;
      const y = (0.5 - 0.5 * seen.y) * clientHeight;
      return seen.z < 1 && Math.hypot(x - at.x, y - at.y) < radius;
    });
  }

  /** @param {PointerEvent} event */
  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const at = this.at(event);
    this.pointers.set(event.pointerId, at);
    const { view } = this.picture;
    if (this.pointers.size === 2) {
      const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1] ?? at;
      const apart = (/** @type {{ x: number, y: number }} */ p) =>
        Math.max(10, Math.hypot(p.x - other.x, p.y - other.y));
      view.zoom(apart(before) / apart(at));
      return;
    }
    this.moved += Math.hypot(at.x - before.x, at.y - before.y);
    switch (this.held.kind) {
      case 'air':
        view.orbit((at.x - before.x) * ORBIT_RATE, (at.y - before.y) * ORBIT_RATE);
        break;
      case 'listener': {
        const { index } = this.held;
        const place = this.listeners.places[index];
        this.actions.moveListener(index, this.picture.pointFacing(at.x, at.y, place));
        break;
      }
      case 'ball': {
        const { body, place } = this.held;
        // The ball continues to move while the arrow is drawn; the arrow follows it.
        place.fromArray(this.picture.poses, body * 7);
        const end = this.picture.pointFacing(at.x, at.y, place);
        this.picture.showArrow(place, end);
        const speed = end.distanceTo(place) * this.actions.throwRate();
        this.actions.tell(`${speed.toFixed(1)} m/s`, at.x, at.y);
        break;
      }
    }
  }

  /** @param {PointerEvent} event */
  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    const at = this.at(event);
    const { held } = this;
    const tapped = this.moved < TAP_SLACK;
    if (held.kind === 'ball') {
      held.place.fromArray(this.picture.poses, held.body * 7);
      const velocity = tapped
        ? new Vector3(0, 0.6 * Math.sqrt(9.81 * this.picture.scale), 0)
        : this.picture
            .pointFacing(at.x, at.y, held.place)
            .sub(held.place)
            .multiplyScalar(this.actions.throwRate());
      this.actions.throwBall(held.body, velocity);
    } else if (held.kind === 'listener' && tapped) {
      this.actions.listenFrom(held.index);
    } else if (held.kind === 'air' && tapped) {
      this.actions.drop(this.picture.pointFacing(at.x, at.y, this.picture.view.target));
    }
    this.letGo();
  }

  /** @param {PointerEvent} event */
  cancel(event) {
    this.pointers.delete(event.pointerId);
    this.letGo();
  }

  letGo() {
    this.picture.hideArrow();
    this.actions.tell('', 0, 0);
    this.held = { kind: 'nothing' };
  }
}
