// Checks that run in the page; each returns its faults as texts. They stand alone, because the browser gets
// their source.

/**
 * Controls are inside the window or its scrolling parts, uncovered, of 44 pixels, and their text is whole.
 */
export function checkWindow() {
  const LEAST = 44;
  /** @type {string[]} */
  const faults = [];
  const root = document.documentElement;
  const scrolls = document.body.scrollWidth > innerWidth || document.body.scrollHeight > innerHeight;
  if (root.scrollWidth > innerWidth || root.scrollHeight > innerHeight || scrolls)
    faults.push('the page scrolls');
  const controls = document.querySelectorAll(
    'button, select, summary, label:has(input), input[type="range"]',
  );
  for (const control of controls) {
    if (control.closest('dialog') || !control.checkVisibility()) continue;
    const name = control.id || (control.textContent ?? '').trim().slice(0, 20);
    // A slider lies in its label.
    if (control.matches('label:has(input[type="range"])') || control.matches('label:has(select)')) continue;
    control.scrollIntoView({ block: 'nearest', inline: 'nearest' });
    const { left, right, top, bottom, width, height } = control.getBoundingClientRect();
    const tall = control.matches('input[type="range"]') ? 28 : LEAST;
    if (matchMedia('(pointer: coarse)').matches && (width < LEAST - 0.5 || height < tall - 0.5)) {
      faults.push(`${name} is ${width.toFixed(0)} × ${height.toFixed(0)} pixels`);
    }
    if (left < -0.5 || top < -0.5 || right > innerWidth + 0.5 || bottom > innerHeight + 0.5) {
      faults.push(`${name} is outside of the window`);
    }
    const hit = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
    if (!hit || !(control.contains(hit) || hit.contains(control))) {
      faults.push(`${name} is covered by ${hit?.id || hit?.tagName}`);
    }
  }
  for (const text of document.querySelectorAll('h1, h2, p, button, label, output, summary, #level, #peak')) {
    if (text.closest('dialog') || !text.checkVisibility() || text.matches('.visually-hidden, :has(canvas)'))
      continue;
    if (text.clientWidth > 0 && text.scrollWidth > text.clientWidth + 1) {
      faults.push(`“${(text.textContent ?? '').trim().slice(0, 30)}” is clipped`);
    }
  }
  const settings = /** @type {HTMLElement} */ (document.getElementById('settings'));
  settings.scrollTop = 0;
  if (settings.scrollWidth > settings.clientWidth) faults.push('the settings are wider than their place');
  const { controls: parts } = Reflect.get(globalThis, 'clangor');
  parts.leaveRoom();
  const tabs = /** @type {HTMLElement} */ (document.getElementById('presets')).getBoundingClientRect();
  const chosen = document.querySelector('#presets label:has(:checked)')?.getBoundingClientRect();
  if (!chosen || chosen.left < tabs.left - 1 || chosen.right > tabs.right + 1)
    faults.push('the chosen tab is off');
  return faults;
}

/** Every object of the scene can be struck: its middle is drawn where nothing covers the picture. */
export function checkScene() {
  const { picture, stage } = Reflect.get(globalThis, 'clangor');
  /** @type {string[]} */
  const faults = [];
  for (const { solid, position } of stage.objects) {
    const [low, high] = [Math.min, Math.max].map((choose) =>
      [0, 1, 2].map((axis) => {
        let best = solid.vertices[axis];
        for (let at = axis; at < solid.vertices.length; at += 3) best = choose(best, solid.vertices[at]);
        return best + position[axis];
      }),
    );
    for (let corner = 0; corner < 8; corner += 1) {
      const point = [0, 1, 2].map((axis) => (corner & (1 << axis) ? high : low)[axis]);
      const seen = picture.view.target.clone().fromArray(point).project(picture.view.camera);
      const x = (0.5 + 0.5 * seen.x) * innerWidth;
      const y = (0.5 - 0.5 * seen.y) * innerHeight;
      const hit = document.elementFromPoint(x, y);
      if (hit?.id === 'picture') continue;
      faults.push(`${solid.name} at ${x.toFixed(0)}, ${y.toFixed(0)} is under ${hit?.id || hit?.tagName}`);
      break;
    }
  }
  return faults;
}

/** Every control has a name for those who do not see it. */
export function checkNames() {
  const faults = [];
  for (const control of document.querySelectorAll(
    'button, input, select, summary, canvas, dialog, [role]:not([role="alert"])',
  )) {
    const labels = /** @type {HTMLInputElement} */ (control).labels;
    const by = control.getAttribute('aria-labelledby');
    const name =
      control.getAttribute('aria-label') ??
      (by ? document.getElementById(by)?.textContent : undefined) ??
      (labels && labels.length > 0 ? labels[0].textContent : control.textContent);
    if (!(name ?? '').trim() && control.getAttribute('aria-hidden') !== 'true')
      faults.push(control.outerHTML.slice(0, 80));
  }
  const ids = [...document.querySelectorAll('[id]')].map(({ id }) => id);
  faults.push(...ids.filter((id, index) => ids.indexOf(id) !== index));
  return faults;
}

/**
 * Contrast of each text with what is behind it, by WCAG 2.2; transparent backgrounds lie over the page's own.
 * @param {number} least
 */
export function checkContrast(least) {
  const paint = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
  if (!paint) return ['no canvas'];
  /** @param {string[]} layers from back to front @returns {number} relative luminance */
  const luminance = (layers) => {
    for (const layer of layers) {
      paint.fillStyle = layer;
      paint.fillRect(0, 0, 1, 1);
    }
    const [r, g, b] = [...paint.getImageData(0, 0, 1, 1).data].map((value) => {
      const part = value / 255;
      return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const faults = [];
  const modal = document.querySelector('dialog[open]');
  const walker = document.createTreeWalker(modal ?? document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const text = (node.textContent ?? '').trim();
    const holder = node.parentElement;
    if (!text || !holder?.checkVisibility() || holder.matches('option, .visually-hidden, #overlay *'))
      continue;
    const backgrounds = [];
    for (let at = /** @type {Element | null} */ (holder); at; at = at.parentElement) {
      backgrounds.unshift(getComputedStyle(at).backgroundColor);
    }
    const behind = luminance(backgrounds);
    const front = luminance([...backgrounds, getComputedStyle(holder).color]);
    const contrast = (Math.max(front, behind) + 0.05) / (Math.min(front, behind) + 0.05);
    if (contrast < least) faults.push(`“${text.slice(0, 30)}”: ${contrast.toFixed(2)}`);
  }
  return faults;
}
