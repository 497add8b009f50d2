// Measures given by formulas: a module of their own computes them, sines and the like included.

import { instantiated } from "./modules.mjs";

export class Formulas {
  /** @param {WebAssembly.Module} module @param {string} entry @param {number} own  bytes of its constants
   * @param {number} count  of all measures */
  constructor(module, entry, own, count) {
    const made = instantiated(module, entry, own, 8 * count);
    this.entry = made.entry;
    this.base = made.base;
    this.values = new Float64Array(made.memory.buffer, made.base, count);
  }

  /** All measures, from those of signals, which come first. @param {number[]} signals */
  computed(signals) {
    this.values.set(signals);
    this.entry(this.base);
    return [...this.values];
  }
}
