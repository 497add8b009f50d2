// Runs the loop beside the page: newer wishes end older ones, so that dragging never waits.

import { Engine, digest, numbers } from "./engine.mjs";
import { envelope, spectrum } from "./figures.mjs";

const FIRST = 1 << 12; // ticks of the first chunk
const CHUNK = 25; // milliseconds

/**
 * @typedef {import("./engine.mjs").Trace} Trace
 * @typedef {{first: number, last: number, pixels: number, spectra: boolean}} View  seconds, of all traces
 * @typedef {{rows: number, period: number, values: Float64Array, trace: Trace,
 *   spectrum?: {x: Float64Array, y: Float64Array} | null}} Series
 */

/** @param {(message: any) => void} post */
export function makeWorker(post) {
  /** @type {Engine | null} */
  let engine = null;
  /** @type {Engine | null} */
  let other = null; // of which wires are looked at, while the first one runs
  /** @type {Series[]} */
  let current = [];
  /** @type {Series[]} */
  let frozen = [];
  let newest = 0; // number of the newest wish for a run
  /** @type {View} */
  let view = { first: 0, last: 0, pixels: 600, spectra: false };

  const turn = () => new Promise((resume) => setTimeout(resume));

  /** @param {any} wish */
  async function run(wish) {
    if (!engine) return;
    const began = performance.now(), probes = engine.loop.probes;
    const ticks = Math.min(wish.settings.ticks, Engine.mostTicks(probes));
    engine.begin({ ...wish.settings, ticks });
    let chunk = FIRST, sound = true, told = began;
    while (engine.tick < ticks && sound) {
      const before = performance.now();
      sound = engine.advance(Math.min(ticks, engine.tick + chunk));
      const taken = performance.now() - before;
      if (taken < CHUNK / 2) chunk *= 2;
      else if (taken > 2 * CHUNK) chunk = Math.max(1, chunk >> 1);
      if (engine.tick < ticks && performance.now() - told > 2 * CHUNK) {
        told = performance.now();
        post({ kind: "progress", part: engine.tick / ticks });
        await turn();
        if (wish.number !== newest) return;
      }
    }
    const [top, bottom] = engine.loop.rate;
    current = engine.traces().map((view) => {
      const trace = { ...view, values: view.values.slice() }; // the next run writes where the view looks
      return { rows: trace.rows, period: (trace.probe.stride * bottom) / top, values: numbers(trace), trace };
    });
    view = wish.view;
    const fault = sound ? "" : "a number is not finite, or does not fit its format";
    const facts = { number: wish.number, ticks: engine.tick, wanted: wish.settings.ticks, fault };
    const measures = engine.measures();
    post({ kind: "done", ...facts, milliseconds: performance.now() - began, measures, pictures: pictures() });
  }

  function pictures() {
    return current.map((series) => {
      const before = frozen.find((one) => one.trace.probe.signal === series.trace.probe.signal);
      const { signal, shape } = series.trace.probe;
      if (shape.length) return { signal, ...vector(series), frozen: before ? vector(before).y : null };
      if (view.spectra) {
        const made = densities(series), old = before && densities(before);
        return { signal, x: made?.x ?? [], y: made?.y ?? [], frozen: old?.y ?? null, frozenX: old?.x ?? null };
      }
      const first = Math.max(0, Math.floor(view.first / series.period));
      const last = Math.min(series.rows, Math.ceil(view.last / series.period) + 1);
      const made = envelope(series.values, first, Math.max(first, last), view.pixels, series.period);
      const old = before && envelope(before.values, first, Math.max(first, last), view.pixels, before.period);
      return { signal, ...made, frozen: old?.y ?? null, frozenX: old?.x ?? null };
    });
  }

  /** The spectrum of a trace, computed once. @param {Series} series */
  function densities(series) {
    if (series.spectrum === undefined) series.spectrum = spectrum(series.values, 1 / series.period);
    return series.spectrum;
  }

  /** The last row of a vector. @param {Series} series */
  function vector(series) {
    const { entries, rows } = series.trace;
    const y = series.values.slice(Math.max(0, rows - 1) * entries, rows * entries);
    return { x: Float64Array.from(y, (_, i) => i), y };
  }

  return async (/** @type {any} */ wish) => {
    try {
      if (wish.kind === "open") {
        engine = await Engine.open(wish.loop);
        other = engine.beside();
        current = [];
        post({ kind: "opened" });
      } else if (wish.kind === "run") {
        newest = wish.number;
        await run(wish);
      } else if (wish.kind === "view") {
        view = wish.view;
        post({ kind: "pictures", pictures: pictures() });
      } else if (wish.kind === "freeze") {
        frozen = wish.on ? current : [];
        post({ kind: "pictures", pictures: pictures() });
      } else if (wish.kind === "peek" && other) {
        other.begin({ ...wish.settings, ticks: wish.tick + 1 });
        other.advance(wish.tick + 1);
        post({ kind: "peek", tick: wish.tick, wires: other.wires() });
      } else if (wish.kind === "digest") {
        const number = newest;
        const traces = current.map(({ trace }) => trace);
        const text = traces.length ? await digest(traces) : "";
        if (number === newest) post({ kind: "digest", text });
      }
    } catch (error) {
      post({ kind: "failed", text: String(error) });
    }
  };
}
