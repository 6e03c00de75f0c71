// A ring at each contact that grows for a third of a second. Computed from the contacts around the shown
// time, so that it is correct in replay, in slow motion and while scrubbing.

import {
  AdditiveBlending,
  DynamicDrawUsage,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Mesh,
  PlaneGeometry,
  ShaderMaterial,
} from 'three';

/** Duration of a ring [s]. */
export const RIPPLE_TIME = 0.33;

/** Largest number of rings; the latest are drawn. */
const MOST = 96;

const VERTEX = /* glsl */ `
  attribute vec4 ring;
  attribute float strength;
  varying vec2 vAt;
  varying float vFade;
  void main() {
    vAt = position.xy;
    vFade = strength;
    vec4 at = viewMatrix * vec4(ring.xyz, 1.0);
    at.xy += position.xy * ring.w;
    gl_Position = projectionMatrix * at;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 accent;
  varying vec2 vAt;
  varying float vFade;
  void main() {
    float r = length(vAt);
    float rim = smoothstep(0.72, 0.92, r) * (1.0 - smoothstep(0.92, 1.0, r));
    float inside = 0.15 * (1.0 - smoothstep(0.0, 0.9, r));
    gl_FragColor = vec4(accent * (rim + inside) * vFade, 1.0);
  }
`;

export class RipplesPicture {
  /** @param {import('three').Color} accent */
  constructor(accent) {
    const form = new PlaneGeometry(2, 2);
    const geometry = new InstancedBufferGeometry();
    geometry.index = form.index;
    geometry.setAttribute('position', form.getAttribute('position'));
    this.ring = new InstancedBufferAttribute(new Float32Array(4 * MOST), 4).setUsage(DynamicDrawUsage);
    this.strength = new InstancedBufferAttribute(new Float32Array(MOST), 1).setUsage(DynamicDrawUsage);
    geometry.setAttribute('ring', this.ring);
    geometry.setAttribute('strength', this.strength);
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { accent: { value: accent } },
      blending: AdditiveBlending,
      transparent: true,
      depthTest: false,
      depthWrite: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
  }

  /**
   * @param {import('./history.js').Contact[]} contacts of the last `RIPPLE_TIME`
   * @param {number} time that is shown [s]
   * @param {number} scale size of the scene [m]
   */
  update(contacts, time, scale) {
    const shown = contacts.slice(-MOST);
    shown.forEach((contact, i) => {
      const age = (time - contact.time) / RIPPLE_TIME;
      const loud = loudness(contact);
      const size = scale * (0.012 + 0.05 * loud) * (0.35 + 0.65 * Math.sqrt(age));
      const [x, y, z] = contact.point;
      this.ring.setXYZW(i, x, y, z, size);
      this.strength.setX(i, loud * (1 - age) ** 2);
    });
    this.ring.needsUpdate = true;
    this.strength.needsUpdate = true;
    /** @type {InstancedBufferGeometry} */ (this.mesh.geometry).instanceCount = shown.length;
    this.mesh.visible = shown.length > 0;
  }
}

/**
 * Strength of the ring of a contact, 0 to 1, by its approach speed from 0.01 to 4 m/s.
 * @param {import('./history.js').Contact} contact
 */
export function loudness(contact) {
  return Math.min(1, Math.max(0.05, 0.4 + 0.4 * Math.log10(contact.speed / 0.12)));
}
