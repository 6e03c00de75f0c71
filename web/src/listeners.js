// Four listener positions, one of them active, or the position of the camera. Each is a pair of ears 17 cm
// apart that faces the middle of the scene.

import { Vector3 } from 'three';

/** Distance between the ears [m]. */
const SPACING = 0.17;

/** Least height of a listener above the ground [m]. */
const CLEARANCE = 0.02;

export class Listeners {
  constructor() {
    /** @type {Vector3[]} */
    this.places = [];
    this.middle = new Vector3();
    this.active = 0;
    this.followsCamera = false;
    this.floorHeight = -Infinity;
  }

  /** @param {number[][]} places [m] @param {number[]} middle of the scene [m] */
  set(places, middle) {
    this.places = places.map((place) => new Vector3().fromArray(place));
    this.middle.fromArray(middle);
    this.active = 0;
  }

  /** @param {number} index @param {Vector3} place */
  move(index, place) {
    place.y = Math.max(place.y, this.floorHeight + CLEARANCE);
    this.places[index].copy(place);
  }

  /**
   * The active ears.
   * @param {import('./orbit-camera.js').OrbitCamera} view
   * @returns {import('./sound.js').Ears}
   */
  ears(view) {
    const place = this.followsCamera ? view.camera.position.clone() : this.places[this.active].clone();
    place.y = Math.max(place.y, this.floorHeight + CLEARANCE);
    const ahead = this.followsCamera ? view.ahead() : this.middle.clone().sub(place);
    const right = ahead.cross(new Vector3(0, 1, 0));
    if (right.lengthSq() < 1e-9) right.set(1, 0, 0);
    right.setLength(SPACING / 2);
    return {
      left: place.clone().sub(right).toArray(),
      right: place.clone().add(right).toArray(),
    };
  }
}
