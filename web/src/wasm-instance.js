// One instance of clangor.wasm with its own memory: passes text, bytes and numbers in and out. The exports
// are those of crates/clangor-web; this file only handles memory.

import { Refusal } from './messages.js';

/** A failure with the message of the module. */
export class ModuleError extends Refusal {}

export class WasmInstance {
  /** @param {WebAssembly.Module} module */
  constructor(module) {
    /** @type {Record<string, any>} */
    this.exports = new WebAssembly.Instance(module, {}).exports;
    // Views are renewed when the memory has grown, which detaches its old buffer.
    this.buffer = null;
    this.refresh();
  }

  refresh() {
    const buffer = this.exports.memory.buffer;
    if (this.buffer === buffer) return;
    this.buffer = buffer;
    this.bytes = new Uint8Array(buffer);
    this.doubles = new Float64Array(buffer);
    this.floats = new Float32Array(buffer);
  }

  /**
   * Copies bytes into the scratch buffer, for the call that follows.
   * @param {Uint8Array} bytes
   * @returns {number} how many
   */
  writeBytes(bytes) {
    const pointer = this.exports.buffer(bytes.length);
    this.refresh();
    this.bytes.set(bytes, pointer);
    return bytes.length;
  }

  /**
   * Copies numbers into the scratch buffer, for the call that follows.
   * @param {Float64Array} numbers
   */
  writeNumbers(numbers) {
    const pointer = this.exports.buffer(numbers.length * 8);
    this.refresh();
    this.doubles.set(numbers, pointer / 8);
  }

  /**
   * A copy of numbers that the module points at.
   * @param {number} pointer
   * @param {number} count
   */
  readNumbers(pointer, count) {
    this.refresh();
    return this.doubles.slice(pointer / 8, pointer / 8 + count);
  }

  /**
   * A copy of single-precision numbers that the module points at.
   * @param {number} pointer
   * @param {number} count
   */
  readFloats(pointer, count) {
    this.refresh();
    return this.floats.slice(pointer / 4, pointer / 4 + count);
  }

  /** The module's last message. The worklet's scope has no TextDecoder, hence the bytes one by one. */
  message() {
    const pointer = this.exports.message();
    const length = this.exports.message_length();
    this.refresh();
    const bytes = this.bytes.subarray(pointer, pointer + length);
    if (typeof TextDecoder !== 'undefined') return new TextDecoder().decode(bytes);
    return String.fromCharCode(...bytes.subarray(0, 4096));
  }

  /**
   * Returns a status, or throws the module's message for a negative one.
   * @param {number} status
   */
  check(status) {
    if (status < 0) throw new ModuleError(this.message());
    return status;
  }
}
