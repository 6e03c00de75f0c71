// Marks of the four listeners: a numbered head of constant size on the screen, with a line down to the
// ground.

import { BufferGeometry, Color, Group, Line, LineBasicMaterial, Vector3 } from 'three';

const QUIET = new Color('#8793a5');

export class ListenersPicture {
  /**
   * @param {Color} accent
   * @param {HTMLElement} overlay holds the heads
   */
  constructor(accent, overlay) {
    this.group = new Group();
    this.accent = accent;
    this.marks = [0, 1, 2, 3].map((index) => {
      const material = new LineBasicMaterial({ color: QUIET, transparent: true, opacity: 0.35 });
      const ends = [new Vector3(), new Vector3(0, -1, 0)];
      const thread = new Line(new BufferGeometry().setFromPoints(ends), material);
      this.group.add(thread);
      const head = document.createElement('span');
      head.className = 'listener';
      head.textContent = String(index + 1);
      overlay.append(head);
      return { thread, material, head };
    });
  }

  /**
   * @param {import('./listeners.js').Listeners} listeners
   * @param {import('three').Camera} camera
   * @param {number} width of the picture in CSS pixels
   * @param {number} height
   * @param {{ top: number, right: number, bottom: number, left: number }} covered at its edges
   */
  update(listeners, camera, width, height, covered) {
    this.marks.forEach(({ thread, material, head }, index) => {
      const place = listeners.places[index];
      const at = place?.clone().project(camera);
      thread.visible = place !== undefined && Number.isFinite(listeners.floorHeight);
      head.hidden = !at || at.z >= 1;
      if (!at) return;
      const active = index === listeners.active && !listeners.followsCamera;
      thread.position.copy(place);
      thread.scale.y = Math.max(1e-6, place.y - listeners.floorHeight);
      material.color.copy(active ? this.accent : QUIET);
      head.classList.toggle('active', active);
      const x = (0.5 + 0.5 * at.x) * width;
      const y = (0.5 - 0.5 * at.y) * height;
      const free =
        x > covered.left && x < width - covered.right && y > covered.top && y < height - covered.bottom;
      head.hidden ||= !free;
      head.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    });
  }
}
