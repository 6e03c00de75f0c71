// A camera that orbits a point, given by two angles and a distance.

import { PerspectiveCamera, Vector3 } from 'three';

/** Least free part of the window that the scene is scaled to; what is smaller shows nothing. */
const LEAST_FREE = 0.1;

/** Steps back at most until the scene is in the window; each comes nearer. */
const FIT_ATTEMPTS = 6;

/** Angles in degrees.
 * @typedef {{ target: number[], distance: number, azimuth: number, elevation: number }} View */

export class OrbitCamera {
  constructor() {
    this.camera = new PerspectiveCamera(38, 1, 0.01, 100);
    this.target = new Vector3();
    this.distance = 1;
    this.azimuth = 0;
    this.elevation = 0.3;
    /** Factor of the distance in narrow windows. */
    this.stepBack = 1;
    /** Where the scene is seen from at first. */
    this.home = { azimuth: 0, elevation: 0.3, distance: 1 };
  }

  /** @param {View} view */
  set({ target, distance, azimuth, elevation }) {
    this.target.fromArray(target);
    this.distance = distance;
    this.nearest = 0.15 * distance;
    this.furthest = 5 * distance;
    this.azimuth = (azimuth * Math.PI) / 180;
    this.elevation = (elevation * Math.PI) / 180;
    const { azimuth: turned, elevation: raised } = this;
    this.home = { azimuth: turned, elevation: raised, distance };
    this.place();
  }

  /**
   * @param {number} width of the canvas in CSS pixels
   * @param {number} height
   * @param {{ top: number, right: number, bottom: number, left: number }} covered at its edges
   * @param {number[][]} corners of the scene [m]
   */
  resize(width, height, covered, corners) {
    const least = LEAST_FREE * Math.min(width, height);
    const free = [width - covered.left - covered.right, height - covered.top - covered.bottom].map((size) =>
      Math.max(least, size),
    );
    // The scene is centred in the free area and scaled to it.
    const across = (covered.left - covered.right) / 2;
    const down = (covered.top - covered.bottom) / 2;
    this.camera.aspect = width / height;
    this.camera.setViewOffset(width, height, -across, -down, width, height);
    this.stepBack = Math.max(height / free[1], (1.25 * height) / free[0]);
    this.fit(free[0] / width, (2 * across) / width, corners);
  }

  /**
   * Steps back until all corners are between the sides of the free area, as seen from where the scene begins.
   * @param {number} share of the width that is free
   * @param {number} middle of the free area, from −1 to 1
   * @param {number[][]} corners [m]
   */
  fit(share, middle, corners) {
    const { azimuth, elevation, distance } = this;
    Object.assign(this, this.home);
    for (let attempt = 0; attempt < FIT_ATTEMPTS; attempt += 1) {
      this.place();
      const reach = corners.map((corner) =>
        Math.abs(new Vector3().fromArray(corner).project(this.camera).x - middle),
      );
      const excess = Math.max(...reach, 0) / share;
      if (!(excess > 1)) break;
      this.stepBack *= Math.min(2, excess);
    }
    Object.assign(this, { azimuth, elevation, distance });
    this.place();
  }

  /** @param {number} sideways @param {number} upwards both in radians */
  orbit(sideways, upwards) {
    this.azimuth -= sideways;
    this.elevation = Math.min(1.5, Math.max(-0.05, this.elevation + upwards));
    this.place();
  }

  /** @param {number} factor of the distance */
  zoom(factor) {
    this.distance = Math.min(this.furthest, Math.max(this.nearest, this.distance * factor));
    this.place();
  }

  place() {
    const { camera, target, azimuth, elevation } = this;
    const distance = this.distance * this.stepBack;
    camera.position.set(
      target.x + distance * Math.cos(elevation) * Math.sin(azimuth),
      target.y + distance * Math.sin(elevation),
      target.z + distance * Math.cos(elevation) * Math.cos(azimuth),
    );
    camera.near = distance * 0.02;
    camera.far = distance * 30;
    camera.lookAt(target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  /** Direction in which the camera looks, of length 1. */
  ahead() {
    return this.camera.getWorldDirection(new Vector3());
  }
}
