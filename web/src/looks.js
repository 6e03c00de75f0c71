// Appearance of materials by name: colour and kind of surface. Other names get a distinct colour.

import { Color } from 'three';

/** Kinds of surface of the ball shader. */
const DULL = 0;
const METAL = 1;
const CLEAR = 2;

/** @typedef {{ colour: Color, surface: number, stripe: number }} Look */

/** @type {Record<string, [string, number]>} */
const LOOKS = {
  'table-steel': ['#a9a49c', METAL],
  steel: ['#c3cad3', METAL],
  copper: ['#d08a62', METAL],
  brass: ['#d9b564', METAL],
  aluminium: ['#dadde0', METAL],
  glass: ['#8fd0d6', CLEAR],
  ceramic: ['#e9e1d4', DULL],
  plastic: ['#e8744f', DULL],
  wood: ['#b98a5a', DULL],
  granite: ['#4a4f58', DULL],
  concrete: ['#6b6a67', DULL],
  cloth: ['#1f5f56', DULL],
  cushion: ['#174a44', DULL],
};

const POOL = ['#e6b93f', '#2f5fbf', '#c8443c', '#6a4a9c', '#dd7a3a', '#2c8a5c', '#8a3038', '#20242c'];

/**
 * @param {string} material name
 * @param {number} index of the body, which colours the balls of pool
 * @returns {Look}
 */
export function lookOf(material, index) {
  if (material === 'phenolic') {
    if (index === 0) return { colour: new Color('#f1ece0'), surface: DULL, stripe: 0 };
    const number = (index - 1) % 15;
    return {
      colour: new Color(POOL[number % 8]),
      surface: DULL,
      stripe: number >= 8 ? 1 : 0,
    };
  }
  // Materials of a scene are mostly named after their base, such as `tuned-brass`.
  const known = Object.keys(LOOKS).find((name) => material.endsWith(name));
  const look = known && LOOKS[known];
  if (look) return { colour: new Color(look[0]), surface: look[1], stripe: 0 };
  let hash = 0;
  for (const letter of material) hash = (hash * 31 + letter.charCodeAt(0)) % 360;
  return { colour: new Color(`hsl(${hash}, 45%, 60%)`), surface: DULL, stripe: 0 };
}
