// The compiled loop of a graph: its module, its memory, and runs of it. The bits are those of the command line.

import { Formulas } from "./formulas.mjs";
import { LINE, PAGE, aligned, compiled, instantiated, unpacked } from "./modules.mjs";

/**
 * @typedef {{signal: string, unit: string, doc: string, stride: number, phase: number, type: string, bytes: number, held: boolean,
 *   shape: number[], fraction: number | null}} Probe
 * @typedef {{name: string, signal: string, statistic: string, unit: string,
 *   read: {first: number, integer: boolean, place: number} | null}} Measure  null where a formula gives it
 * @typedef {{name: string, unit: string, doc: string, integer: boolean, held: boolean, place: number, fraction: number}} Wire
 * @typedef {{entry: string, module: string, own: number, image: string, imageLength: number,
 *   arrays: {at: number, length: number}[], rate: [number, number], probes: Probe[], measures: Measure[],
 *   formulas: {module: string, own: number} | null, parameters: Record<string, number>, wires: Wire[],
 *   watched: number[], refused: number}} Loop
 * @typedef {{probe: Probe, values: Float64Array | BigInt64Array | Uint8Array, rows: number, entries: number}} Trace
 * @typedef {{values: Record<string, number>, seed: string, run: number, ticks: number}} Settings
 */

const HIGHEST = 1e9; // bytes of rows that a page holds

export class Engine {
  /** @param {Loop} loop @param {Uint8Array} image @param {WebAssembly.Module} module
   * @param {WebAssembly.Module} [ofFormulas] */
  constructor(loop, image, module, ofFormulas) {
    this.loop = loop;
    this.modules = /** @type {const} */ ([module, ofFormulas]);
    this.image = image;
    const { base, memory, entry } = instantiated(module, loop.entry, loop.own, image.length + LINE + PAGE);
    this.base = base;
    this.memory = memory;
    this.entry = entry;
    this.rows = aligned(base + image.length);
    this.formulas = ofFormulas && loop.formulas ? new Formulas(ofFormulas, loop.entry, loop.formulas.own, loop.measures.length) : null;
    /** @type {Settings} */
    this.settings = { values: {}, seed: "0", run: 0, ticks: 0 };
    this.tick = 0;
    /** @type {number[]} */
    this.places = [];
  }

  /** @param {Loop} loop */
  static async open(loop) {
    const image = unpacked(loop.image);
    const [module, ofFormulas] = await compiled([loop.module, ...(loop.formulas ? [loop.formulas.module] : [])]);
    return new Engine(loop, await image, module, ofFormulas);
  }

  /** Another engine of the same loop, with a memory of its own. */
  beside() {
    return new Engine(this.loop, this.image, ...this.modules);
  }

  /** Rows that a probe has after so many ticks. @param {Probe} probe @param {number} ticks */
  static rowsOf(probe, ticks) {
    return Math.max(0, Math.ceil((ticks - probe.phase) / probe.stride));
  }

  /** Bytes of a row. @param {Probe} probe */
  static rowBytes(probe) {
    return probe.bytes * probe.shape.reduce((product, length) => product * length, 1);
  }

  /** The most ticks that fit into the memory of a page. @param {Probe[]} probes */
  static mostTicks(probes) {
    const bytes = probes.reduce((sum, probe) => sum + Engine.rowBytes(probe) / probe.stride, 0);
    return Math.floor(HIGHEST / Math.max(bytes, 1));
  }

  /** Go back to tick 0. @param {Settings} settings */
  begin(settings) {
    this.settings = settings;
    this.tick = 0;
    let at = this.rows;
    this.places = this.loop.probes.map((probe) => {
      const place = at;
      at = aligned(at + Engine.rowsOf(probe, settings.ticks) * Engine.rowBytes(probe) + LINE);
      return place;
    });
    const missing = Math.ceil((at - this.memory.buffer.byteLength) / PAGE);
    if (missing > 0) this.memory.grow(missing);
    new Uint8Array(this.memory.buffer).set(this.image, this.base);
    const constants = this.floats(0);
    for (const [name, value] of Object.entries(settings.values)) constants[this.loop.parameters[name]] = value;
  }

  /** One of the arrays of floats. @param {number} number */
  floats(number) {
    const { at, length } = this.loop.arrays[number];
    return new Float64Array(this.memory.buffer, this.base + at, length);
  }

  /** One of the arrays of integers. @param {number} number */
  integers(number) {
    const { at, length } = this.loop.arrays[number];
    return new BigInt64Array(this.memory.buffer, this.base + at, length);
  }

  /** Run up to, not including, a tick; false where a number was not finite or did not fit. @param {number} last */
  advance(last) {
    this.floats(4).fill(NaN);
    const { seed, run } = this.settings;
    const begun = (/** @type {Probe} */ probe) => Engine.rowsOf(probe, this.tick) * Engine.rowBytes(probe);
    const rows = this.loop.probes.map((probe, number) => this.places[number] + begun(probe));
    const arrays = this.loop.arrays.map(({ at }) => this.base + at);
    this.entry(BigInt(this.tick), BigInt(last), BigInt(seed), BigInt(run), ...arrays, ...rows);
    this.tick = last;
    const state = this.floats(2);
    return this.loop.watched.every((place) => Number.isFinite(state[place])) && !this.integers(3)[this.loop.refused];
  }

  /** What the probes have recorded; views of the memory, good until the next run. @returns {Trace[]} */
  traces() {
    return this.loop.probes.map((probe, number) => {
      const rows = Engine.rowsOf(probe, this.tick);
      const entries = probe.shape.reduce((product, length) => product * length, 1);
      const kinds = { float64: Float64Array, int64: BigInt64Array, bool: Uint8Array };
      const kind = kinds[/** @type {"float64"} */ (probe.type)];
      return { probe, rows, entries, values: new kind(this.memory.buffer, this.places[number], rows * entries) };
    });
  }

  /** What a wire holds after the last tick. @param {Wire} wire */
  wire(wire) {
    return wire.integer ? Number(this.integers(3)[wire.place]) * 2 ** -wire.fraction : this.floats(2)[wire.place];
  }

  /** What all wires hold after the last tick, by the name of their source. @returns {Record<string, number>} */
  wires() {
    return Object.fromEntries(this.loop.wires.map((wire) => [wire.name, this.wire(wire)]));
  }

  /** Go on with other parameters from this tick on. @param {Record<string, number>} values */
  poke(values) {
    const { at, length } = this.loop.arrays[0];
    const constants = this.floats(0);
    constants.set(new Float64Array(this.image.slice(at, at + 8 * length).buffer));
    for (const [name, value] of Object.entries(values)) constants[this.loop.parameters[name]] = value;
  }

  /** Values of the measures by name; NaN where the run ended before one began. @returns {Record<string, number>} */
  measures() {
    const signals = this.loop.measures.flatMap(({ read }) => (read ? [this.reduced(read)] : []));
    const values = this.formulas ? this.formulas.computed(signals) : signals;
    return Object.fromEntries(this.loop.measures.map(({ name }, place) => [name, values[place]]));
  }

  /** The value of a measure of a signal. @param {NonNullable<Measure["read"]>} read */
  reduced(read) {
    if (this.tick <= read.first) return NaN;
    return read.integer ? Number(this.integers(3)[read.place]) : this.floats(2)[read.place];
  }
}

/** The values of a trace as numbers in its unit, those of registers included. @param {Trace} trace */
export function numbers(trace) {
  const { values, probe } = trace;
  if (values instanceof Float64Array) return values;
  const scale = probe.fraction === null ? 1 : 2 ** -probe.fraction;
  if (values instanceof Uint8Array) return Float64Array.from(values);
  const halves = new Int32Array(values.buffer, values.byteOffset, 2 * values.length);
  const made = new Float64Array(values.length);
  for (let i = 0; i < made.length; i++) made[i] = (halves[2 * i + 1] * 4294967296 + (halves[2 * i] >>> 0)) * scale;
  return made;
}

/** SHA-256 of all traces, as the command line has it. @param {Trace[]} traces */
export async function digest(traces) {
  const lines = [];
  for (const trace of [...traces].sort((a, b) => (a.probe.signal < b.probe.signal ? -1 : 1))) {
    const { probe, rows } = trace;
    const values = probe.fraction === null ? trace.values : numbers(trace);
    const kind = probe.fraction === null ? probe.type : "float64";
    const shape = [rows, ...probe.shape].join(" ");
    lines.push(`${probe.signal} ${kind} ${shape} ${await sha256(sound(values))}\n`);
  }
  return sha256(new TextEncoder().encode(lines.join("")));
}

/** The values with one NaN for all. @param {Float64Array | BigInt64Array | Uint8Array} values */
function sound(values) {
  if (!(values instanceof Float64Array) || !values.some(Number.isNaN)) return values.slice();
  return values.map((value) => (Number.isNaN(value) ? NaN : value));
}

/** @param {ArrayBufferView<ArrayBuffer>} data */
async function sha256(data) {
  const bytes = new Uint8Array(await crypto.subtle.digest("SHA-256", data));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
