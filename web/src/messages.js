// Messages for people: whole sentences, without names and numbers of the program's inside.

/** A reason that is written for the reader of the page. */
export class Refusal extends Error {}

/** What the reader can do about failures of the browser, by the name of its exception. */
const BROWSER_FAILURES = new Map([
  ['NotAllowedError', 'the browser blocks sound on this page: allow it and tap again'],
  ['NotSupportedError', 'this browser has no sound output that the page can use'],
  ['AbortError', 'the page was loaded in part: reload it'],
  ['NetworkError', 'the server does not answer: reload the page'],
]);

/**
 * A text as a sentence: with a capital letter and a full stop.
 * @param {string} text
 */
export function sentence(text) {
  const whole = text.trim();
  const ended = /[.!?…]$/.test(whole) ? whole : `${whole}.`;
  return ended.charAt(0).toUpperCase() + ended.slice(1);
}

/**
 * Why something failed, in words for the reader; the console has the details.
 * @param {unknown} error
 * @param {string} otherwise the reason where the error was not written for the reader
 */
export function reason(error, otherwise) {
  if (error instanceof Refusal) return error.message;
  console.warn(error);
  const name = error instanceof Error ? error.name : '';
  return BROWSER_FAILURES.get(name) ?? otherwise;
}
