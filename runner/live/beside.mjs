// What runs beside the run that a page shows: wires recorded tick by tick, many seeds, and walks through the ticks.

import { numbers } from "./engine.mjs";
import { envelope, stepped } from "./figures.mjs";

const TOLD = 120; // milliseconds from one message to the next
const AWAY = 12; // milliseconds that newer wishes wait for
const FRAME = 40; // milliseconds of a frame of a walk
const LONGEST = 4e6; // ticks of which wires are recorded

/**
 * @typedef {import("./engine.mjs").Engine} Engine
 * @typedef {import("./engine.mjs").Wire} Wire
 * @typedef {import("./engine.mjs").Settings} Settings
 * @typedef {import("./worker.mjs").View} View
 * @typedef {(message: any) => void} Post
 */

const turn = (wait = 0) => new Promise((resume) => setTimeout(resume, wait));

/** Values of wires at every tick; null where another wish came. @param {Engine} engine @param {Settings} settings
 * @param {string[]} names @param {() => boolean} wanted */
export async function recorded(engine, settings, names, wanted) {
  const ticks = Math.min(settings.ticks, LONGEST), wires = engine.loop.wires.filter(({ name }) => names.includes(name));
  engine.begin({ ...settings, ticks });
  const values = wires.map(() => new Float64Array(ticks));
  for (let tick = 0, told = performance.now(); tick < ticks; tick++) {
    const sound = engine.advance(tick + 1);
    wires.forEach((wire, i) => (values[i][tick] = engine.wire(wire)));
    if (!sound) break;
    if (tick % 1024 === 1023 && performance.now() - told > AWAY) {
      await turn();
      told = performance.now();
      if (!wanted()) return null;
    }
  }
  return new Map(wires.map((wire, i) => [wire.name, values[i]]));
}

/** Pictures of recorded wires. @param {Map<string, Float64Array>} wires @param {View} view @param {number} period
 * @param {Wire[]} about */
export function wirePictures(wires, view, period, about) {
  const held = new Set(about.filter((wire) => wire.held).map((wire) => wire.name));
  return [...wires].map(([signal, values]) => {
    const first = Math.max(0, Math.floor(view.first / period));
    const last = Math.min(values.length, Math.ceil(view.last / period) + 1);
    const rows = envelope(values, first, Math.max(first, last), view.pixels, period);
    return { signal, ...stepped(rows, held.has(signal), period), frozen: null, frozenX: null };
  });
}

/** Measures of runs with one seed after the other; means of the probes where the graph has no measures.
 * @param {Engine} engine @param {Settings} settings @param {number} count @param {() => boolean} wanted @param {Post} post */
export async function manySeeds(engine, settings, count, wanted, post) {
  /** @type {Record<string, number[]>} */
  const values = {};
  let told = performance.now();
  for (let done = 0; done < count; done++) {
    engine.begin({ ...settings, seed: String(BigInt(settings.seed) + BigInt(done)) });
    for (let chunk = 1 << 14; engine.tick < settings.ticks; ) {
      engine.advance(Math.min(settings.ticks, engine.tick + chunk));
      if (performance.now() - told <= TOLD) continue;
      told = performance.now();
      post({ kind: "seeds", done, count, values });
      await turn();
      if (!wanted()) return;
    }
    for (const [name, value] of Object.entries(measured(engine))) (values[name] ??= []).push(value);
  }
  post({ kind: "seeds", done: count, count, values });
}

/** @param {Engine} engine @returns {Record<string, number>} */
function measured(engine) {
  if (engine.loop.measures.length) return engine.measures();
  const scalar = engine.traces().filter(({ probe }) => !probe.shape.length);
  return Object.fromEntries(scalar.map((trace) => {
    const all = numbers(trace);
    return [`mean of ${trace.probe.signal}`, all.reduce((sum, value) => sum + value, 0) / all.length];
  }));
}

/** A run that a person leads: tick by tick, or on its own until it is told to pause. */
export class Walk {
  /** @param {Engine} engine @param {Settings} settings @param {Post} post @param {() => any[]} pictures */
  constructor(engine, settings, post, pictures) {
    this.engine = engine;
    this.post = post;
    this.pictures = pictures;
    this.playing = 0; // number of the newest wish to play; 0 while it stands still
    this.sound = true;
    engine.begin(settings);
  }

  /** @param {number} tick */
  to(tick) {
    const last = Math.min(tick, this.engine.settings.ticks);
    if (this.sound && last > this.engine.tick) this.sound = this.engine.advance(last);
  }

  tell() {
    const { tick, settings } = this.engine;
    const wires = tick ? this.engine.wires() : {};
    this.post({ kind: "walk", tick, ticks: settings.ticks, wires, playing: this.playing > 0, sound: this.sound, pictures: this.pictures() });
  }

  /** @param {number} pace  ticks of a frame */
  async play(pace) {
    const own = (this.playing = performance.now());
    while (this.playing === own && this.sound && this.engine.tick < this.engine.settings.ticks) {
      this.to(this.engine.tick + pace);
      this.tell();
      await turn(FRAME);
    }
    if (this.playing === own) this.playing = 0;
    this.tell();
  }
}
