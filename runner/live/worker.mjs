// Runs the loop beside the page: newer wishes end older ones, so that dragging never waits.

import { Walk, manySeeds, recorded, wirePictures } from "./beside.mjs";
import { Engine, digest, numbers } from "./engine.mjs";
import { envelope, spectrum, stepped } from "./figures.mjs";

const FIRST = 1 << 12; // ticks of the first chunk
const CHUNK = 25; // milliseconds

/**
 * @typedef {import("./engine.mjs").Trace} Trace
 * @typedef {{first: number, last: number, pixels: number, spectra: boolean}} View  seconds, of all traces
 * @typedef {{rows: number, period: number, late: number, values: Float64Array, trace: Trace,
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
  /** @type {Map<string, Float64Array>} */
  let wires = new Map(); // recorded tick by tick
  /** @type {Walk | null} */
  let walk = null;
  let newest = 0; // number of the newest wish for a run
  let seeds = 0, records = 0; // numbers of the newest wishes for them
  /** @type {View} */
  let view = { first: 0, last: 0, pixels: 600, spectra: false };

  const turn = () => new Promise((resume) => setTimeout(resume));

  /** @param {any} wish */
  async function run(wish) {
    if (!engine) return;
    const began = performance.now(), probes = engine.loop.probes;
    const ticks = Math.min(wish.settings.ticks, Engine.mostTicks(probes));
    engine.begin({ ...wish.settings, ticks });
    let chunk = FIRST, sound = true, told = began, loop = 0;
    while (engine.tick < ticks && sound) {
      const before = performance.now();
      sound = engine.advance(Math.min(ticks, engine.tick + chunk));
      const taken = performance.now() - before;
      loop += taken;
      if (taken < CHUNK / 2) chunk *= 2;
      else if (taken > 2 * CHUNK) chunk = Math.max(1, chunk >> 1);
      if (engine.tick < ticks && performance.now() - told > 2 * CHUNK) {
        told = performance.now();
        post({ kind: "progress", part: engine.tick / ticks });
        await turn();
        if (wish.number !== newest) return;
      }
    }
    current = seriesOf(engine);
    view = wish.view;
    const fault = sound ? "" : "a number is not finite, or does not fit its format";
    const facts = { number: wish.number, ticks: engine.tick, wanted: wish.settings.ticks, fault, loop };
    const measures = engine.measures();
    post({ kind: "done", ...facts, milliseconds: performance.now() - began, measures, pictures: pictures() });
  }

  /** What the probes of an engine have recorded; the next run writes where its views look. @param {Engine} of */
  function seriesOf(of) {
    const [top, bottom] = of.loop.rate;
    return of.traces().map((own) => {
      const trace = { ...own, values: own.values.slice() };
      const { stride, phase } = trace.probe;
      return { rows: trace.rows, period: (stride * bottom) / top, late: (phase * bottom) / top, values: numbers(trace), trace };
    });
  }

  function period() {
    const [top, bottom] = engine?.loop.rate ?? [1, 1];
    return bottom / top;
  }

  /** @param {any} wish */
  async function record(wish) {
    const number = ++records, asked = newest;
    if (!engine || !wish.names.length) return void (wires = new Map());
    const made = await recorded(engine.beside(), wish.settings, wish.names, () => number === records && asked === newest);
    if (!made || number !== records) return;
    wires = made;
    post({ kind: "wires", pictures: wirePictures(wires, view, period(), engine?.loop.wires ?? []) });
  }

  /** @param {any} wish */
  async function lead(wish) {
    if (wish.act === "begin" && engine) {
      walk = new Walk(engine.beside(), wish.settings, post, () => walk ? pictures(seriesOf(walk.engine)) : []);
      view = wish.view;
      walk.to(wish.tick);
    }
    if (!walk) return;
    walk.playing = 0;
    if (wish.values) walk.engine.poke(wish.values);
    if (wish.act === "end") walk = null;
    else if (wish.act === "play") await walk.play(wish.pace);
    else {
      if (wish.act === "step") walk.to(walk.engine.tick + wish.ticks);
      walk.tell();
    }
  }

  function pictures(of = current) {
    return of.map((series) => {
      const before = frozen.find((one) => one.trace.probe.signal === series.trace.probe.signal);
      const { signal, shape } = series.trace.probe;
      if (shape.length) return { signal, ...vector(series), frozen: before ? vector(before).y : null };
      if (view.spectra) {
        const made = densities(series), old = before && densities(before);
        return { signal, x: made?.x ?? [], y: made?.y ?? [], frozen: old?.y ?? null, frozenX: old?.x ?? null };
      }
      const [first, last] = seen(series);
      const drawn = (/** @type {Series} */ one) =>
        stepped(envelope(one.values, first, last, view.pixels, one.period, one.late), one.trace.probe.held, one.period);
      const made = drawn(series), old = before && drawn(before);
      return { signal, ...made, frozen: old?.y ?? null, frozenX: old?.x ?? null };
    });
  }

  /** The spectrum of a trace, computed once, or of the stretch that is seen. @param {Series} series */
  function densities(series) {
    const [first, last] = seen(series);
    if (last - first < series.rows) return spectrum(series.values.subarray(first, last), 1 / series.period);
    if (series.spectrum === undefined) series.spectrum = spectrum(series.values, 1 / series.period);
    return series.spectrum;
  }

  /** The first row that is seen, and the one after the last. @param {Series} series */
  function seen(series) {
    const { period, late, rows } = series;
    const first = Math.max(0, Math.floor((view.first - late) / period));
    return [first, Math.max(first, Math.min(rows, Math.ceil((view.last - late) / period) + 1))];
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
        walk = null;
        wires = new Map();
        records++;
        seeds++;
        post({ kind: "opened" });
      } else if (wish.kind === "run") {
        newest = wish.number;
        seeds++;
        await run(wish);
      } else if (wish.kind === "view") {
        view = wish.view;
        post({ kind: "pictures", pictures: pictures(walk ? seriesOf(walk.engine) : current) });
        post({ kind: "wires", pictures: wirePictures(wires, view, period(), engine?.loop.wires ?? []) });
      } else if (wish.kind === "record") await record(wish);
      else if (wish.kind === "walk") await lead(wish);
      else if (wish.kind === "seeds" && engine) {
        const number = ++seeds;
        if (wish.count) await manySeeds(engine.beside(), wish.settings, wish.count, () => number === seeds, post);
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
