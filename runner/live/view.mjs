// The live part of a page: controls beside plots, kept in step with a worker that runs the loop.

import { Charts } from "./charts.mjs";
import { Controls, asOptions, asToml, element, labelled, nameOf } from "./controls.mjs";
import { Diagrams, carriedDrawings } from "./diagrams.mjs";
import { shown, ticksOf } from "./figures.mjs";
import { showHistograms } from "./histograms.mjs";
import { Leading } from "./leading.mjs";
import { TOO_LONG, askForLong } from "./long.mjs";
import { measureTable } from "./measures.mjs";
import { parametersOf } from "./values.mjs";

/**
 * @typedef {{name: string, file: string, seed: string, ticks: number, loop: import("./engine.mjs").Loop,
 *   sliders: import("./controls.mjs").Slider[], fixed: import("./controls.mjs").Fixed[],
 *   units: Record<string, import("./figures.mjs").Scales>, options: string[], named: import("./values.mjs").Named,
 *   drawings?: string}} Model
 * @typedef {{values: Record<string, number>, seed: string, duration: string}} State  of the controls
 * @typedef {{ask: (name: string, text: string) => void, draw: (paths: string[]) => Promise<string>,
 *   long: (wish: any) => void}} Process  that takes what the loop does not take anew, draws, and does long runs
 */

const SEEDS = 300; // of a histogram
const SETTLED = 250; // milliseconds without a change, after which bits are hashed

export class View {
  /** @param {HTMLElement} place @param {() => {postMessage: (wish: any) => void, listen: (hear: (message: any) => void) => void}} makeChannel
   * @param {(state: State) => void} told  hears of every change that a person makes
   * @param {Process | null} process */
  constructor(place, makeChannel, told = () => {}, process = null) {
    this.place = place;
    this.process = process;
    this.told = told;
    this.channel = makeChannel();
    this.channel.listen((message) => this.hear(message));
    /** @type {Model | null} */
    this.model = null;
    /** @type {State} */
    this.state = { values: {}, seed: "", duration: "" };
    /** @type {[number, number] | null} */
    this.zoom = null;
    this.spectra = false;
    this.frozen = false;
    this.number = 0; // of the newest wish for a run
    this.waiting = false; // for a run
    this.again = false; // wanted while one was under way
    /** @type {Record<string, number>} */
    this.measures = {};
    /** @type {Record<string, number>} */
    this.before = {};
    /** @type {Set<string>} */
    this.plotted = new Set(); // wires that are recorded besides the probes
    this.seeds = false; // whether many are run
    place.replaceChildren();
    this.place.hidden = false;
    this.side = element("div", { className: "side" });
    this.main = element("div", { className: "main" });
    this.place.append(this.side, this.main);
    this.duration = labelled(this.side, "duration in s", "run-duration");
    this.seed = labelled(this.side, "seed", "run-seed");
    this.filter = labelled(this.side, "find", "run-find");
    this.filter.type = "search";
    this.list = element("div", { className: "blocks" });
    this.side.append(this.list);
    this.buttons = element("div", { className: "buttons run" });
    this.freezing = this.button("Freeze", "Keep this run to compare with", () => this.freeze(!this.frozen));
    this.kind = this.button("Spectra", "Show amplitude densities", () => this.showSpectra(!this.spectra));
    this.many = this.button("Seeds", `Show the measures of ${SEEDS} seeds`, () => this.showSeeds(!this.seeds));
    this.walking = this.button("Walk", "Go through the run tick by tick, from the time that was clicked", () => this.leading.toggle());
    this.button("Reset", "Go back to the values of the graph", () => this.reset());
    this.button("Copy TOML", "Copy the changed parameters as lines of a graph file", () => this.copy(this.toml()));
    this.button("Copy command", "Copy the command that computes these bits", () => this.copy(this.command()));
    this.status = element("p", { className: "status" });
    this.status.setAttribute("role", "status");
    this.bits = element("p", { className: "bits soft" });
    this.table = element("div", { className: "wide measures" });
    this.histograms = element("div", { className: "histograms", hidden: true });
    this.plots = element("div", { className: "plots" });
    this.main.append(this.buttons);
    this.leading = new Leading(this.main, this.channel, () => this.startOfWalk(), (tick) => this.timeOf(tick), () => this.run());
    this.main.append(this.status, this.bits, this.table, this.histograms, this.plots);
    this.duration.addEventListener("change", () => this.changeDuration());
    this.seed.addEventListener("change", () => this.changeSeed());
    this.filter.addEventListener("input", () => Controls.filter(this.list, this.filter.value));
  }

  /** @param {string} text @param {string} title @param {() => void} act */
  button(text, title, act) {
    const made = element("button", { type: "button", textContent: text, title });
    made.addEventListener("click", act);
    this.buttons.append(made);
    return made;
  }

  /** Show a graph; values of parameters that it still has stay as they were set. @param {Model} model */
  open(model) {
    const old = this.model, names = new Set(model.sliders.map(nameOf));
    this.model = model;
    const kept = Object.entries(this.state.values).filter(([name]) => names.has(name));
    const duration = (old && this.state.duration !== secondsOf(old)) ? this.state.duration : secondsOf(model);
    const seed = old && this.state.seed !== old.seed ? this.state.seed : model.seed;
    this.state = { values: Object.fromEntries(kept), seed, duration };
    const asked = decodeURIComponent(location.hash.slice(1)); // report.html#controller
    const open = new Set(old ? [...this.list.querySelectorAll("details[open] > summary")].map((one) => one.textContent) : [asked]);
    this.list.replaceChildren();
    this.controls = new Controls(this.list, model.sliders, model.fixed, model.units, (name, value) => this.set(name, value), this.process?.ask ?? null);
    for (const group of this.list.querySelectorAll("details")) {
      const block = group.querySelector("summary")?.textContent ?? "";
      group.open = open.has(block) || (!old && block === "values");
    }
    Controls.filter(this.list, this.filter.value);
    this.charts?.remove();
    this.charts = new Charts(this.plots, model.loop.probes, model.units, (range) => this.zoomTo(range), (time) => this.peek(time));
    this.show();
    this.lookAtDiagrams();
    const plotted = [...this.plotted];
    this.plotted.clear();
    for (const name of plotted) this.plot(name);
    if (this.leading.on) this.leading.toggle();
    this.waiting = this.again = false;
    this.channel.postMessage({ kind: "open", loop: model.loop });
    this.run();
  }

  /** Take the diagrams that the page has as maps, unfolded and coloured as those before were. */
  lookAtDiagrams() {
    if (!this.model) return;
    const { loop, units, drawings } = this.model, { unfolded, overlay = "", values, seconds } = this.diagrams ?? {};
    this.diagrams = new Diagrams(loop.wires, units, (name) => this.plot(name), this.process?.draw ?? carriedDrawings(drawings));
    if (unfolded?.size) void this.diagrams.unfold(unfolded);
    if (overlay) this.diagrams.lay(overlay);
    if (values && seconds !== undefined) this.diagrams.show(values, seconds);
  }

  /** Parameters of a run: those that were set, and those that follow from named values. */
  parameters() {
    return this.model ? parametersOf(this.model.named, this.state.values) : {};
  }

  show() {
    this.controls?.show(this.state.values, this.parameters());
    this.duration.value = this.state.duration;
    this.seed.value = this.state.seed;
  }

  /** Take over what another window says. @param {State} state */
  follow(state) {
    this.state = state;
    this.show();
    this.run();
  }

  /** @param {string} name @param {number} value */
  set(name, value) {
    const slider = this.model?.sliders.find((one) => nameOf(one) === name);
    const values = { ...this.state.values, [name]: value };
    if (slider?.value === value) delete values[name];
    this.change({ ...this.state, values });
    if (slider?.named) this.show(); // others follow
  }

  /** @param {State} state */
  change(state) {
    this.state = state;
    this.told(state);
    this.run();
  }

  changeDuration() {
    const wrong = this.model && ticksOf(this.duration.value, this.model.loop.rate) === null;
    this.duration.setCustomValidity(wrong ? "a time in seconds, such as 0.5" : "");
    if (wrong) this.duration.reportValidity();
    else {
      this.zoom = null;
      this.change({ ...this.state, duration: this.duration.value.trim() });
    }
  }

  changeSeed() {
    const wrong = !/^\d{1,18}$/.test(this.seed.value.trim());
    this.seed.setCustomValidity(wrong ? "a whole number, such as 7" : "");
    if (wrong) this.seed.reportValidity();
    else this.change({ ...this.state, seed: this.seed.value.trim() });
  }

  reset() {
    if (!this.model) return;
    this.zoom = null;
    this.change({ values: {}, seed: this.model.seed, duration: secondsOf(this.model) });
    this.show();
  }

  /** @param {[number, number] | null} range */
  zoomTo(range) {
    this.zoom = range;
    this.channel.postMessage({ kind: "view", view: this.view() });
  }

  /** Show what the wires hold at a time. @param {number} seconds */
  peek(seconds) {
    const [top, bottom] = this.model?.loop.rate ?? [1, 1];
    const tick = Math.floor((seconds * top) / bottom + 1e-6);
    this.peeked = Math.min(Math.max(0, tick), this.ticks() - 1);
    this.channel.postMessage({ kind: "peek", tick: this.peeked, settings: { ...this.settings(), ticks: 0 } });
  }

  settings() {
    return { values: this.parameters(), seed: this.state.seed, run: 0, ticks: this.ticks() };
  }

  startOfWalk() {
    this.channel.postMessage({ kind: "record", names: [] });
    return { tick: this.peeked ?? 0, settings: this.settings(), view: this.view() };
  }

  /** Plot a wire, or no longer. @param {string} name */
  plot(name) {
    const wire = this.model?.loop.wires.find((one) => one.name === name);
    if (!wire || !this.charts) return;
    if (this.charts.charts.has(name) && !this.plotted.has(name)) return this.charts.charts.get(name)?.figure.scrollIntoView({ block: "nearest" });
    if (this.plotted.delete(name)) this.charts.drop(name);
    else {
      this.plotted.add(name);
      this.charts.add({ signal: name, unit: wire.unit, doc: wire.doc, stride: 1, type: "float64", bytes: 8, shape: [], fraction: null }, () => this.plot(name));
      this.say(`${name} is plotted; click it again to take it away`);
    }
    this.record();
  }

  record() {
    this.channel.postMessage({ kind: "record", names: [...this.plotted], settings: this.settings() });
  }

  /** @param {boolean} on */
  showSeeds(on) {
    this.seeds = on;
    this.histograms.hidden = !on;
    this.histograms.replaceChildren();
    this.many.setAttribute("aria-pressed", String(on));
    this.channel.postMessage({ kind: "seeds", count: on ? SEEDS : 0, settings: this.settings() });
  }

  /** @param {any} message */
  showSeedValues(message) {
    const last = BigInt(this.state.seed) + BigInt(Math.max(0, message.done - 1));
    const scales = (/** @type {string} */ name) => {
      const of = this.model?.loop.measures.find((one) => one.name === name) ?? this.model?.loop.probes.find(({ signal }) => name.endsWith(` ${signal}`));
      return this.model?.units[of?.unit ?? "1"] ?? [{ exponent: 0, text: "" }];
    };
    if (this.seeds) showHistograms(this.histograms, message.values, scales, `${message.done} of ${message.count} runs, of the seeds ${this.state.seed} to ${last}`);
  }

  /** @param {boolean} on */
  showSpectra(on) {
    this.spectra = on;
    this.kind.textContent = on ? "Traces" : "Spectra";
    this.channel.postMessage({ kind: "view", view: this.view() });
  }

  /** @param {boolean} on */
  freeze(on) {
    this.frozen = on;
    this.before = on ? this.measures : {};
    this.freezing.textContent = on ? "Thaw" : "Freeze";
    this.freezing.setAttribute("aria-pressed", String(on));
    this.channel.postMessage({ kind: "freeze", on });
    this.showMeasures();
  }

  view() {
    const [first, last] = this.zoom ?? [0, this.seconds()];
    return { first, last, pixels: this.charts?.pixels ?? 600, spectra: this.spectra };
  }

  /** Seconds of a tick. @param {number} tick */
  timeOf(tick) {
    const [top, bottom] = this.model?.loop.rate ?? [1, 1];
    return (tick * bottom) / top;
  }

  ticks() {
    return this.model ? (ticksOf(this.state.duration, this.model.loop.rate) ?? this.model.ticks) : 0;
  }

  seconds() {
    return this.timeOf(Math.max(0, this.ticks() - 1));
  }

  /** Wish for a run; while one is under way the newest wish waits for it, or ends it where it is long. */
  run() {
    clearTimeout(this.settling);
    const parameters = this.parameters(), wrong = this.controls?.wrong(parameters);
    if (wrong) return this.say(wrong, true);
    if (this.leading.on) return this.leading.poke(parameters);
    if (this.process && this.ticks() > TOO_LONG) return askForLong(this, this.process.long);
    if (this.waiting && !this.long) {
      this.again = true;
      return;
    }
    this.waiting = true;
    this.number += 1;
    this.channel.postMessage({ kind: "run", number: this.number, settings: this.settings(), view: this.view() });
  }

  /** @param {any} message */
  hear(message) {
    if (message.kind === "failed") this.say(message.text, true);
    else if (message.kind === "progress") this.progress(message.part);
    else if (message.kind === "pictures") this.charts?.draw(message.pictures, this.spectra);
    else if (message.kind === "peek") this.diagrams?.show(message.wires, this.timeOf(message.tick));
    else if (message.kind === "seeds") this.showSeedValues(message);
    else if (message.kind === "walk" && this.leading.on) this.walked(message);
    else if (message.kind === "digest") this.bits.textContent = message.text && `SHA-256 of the traces: ${message.text}`;
    else if (message.kind === "done" && message.number === this.number) this.done(message);
  }

  /** @param {any} message */
  walked(message) {
    this.leading.hear(message);
    this.bits.textContent = "";
    this.charts?.draw(message.pictures, this.spectra);
    if (message.tick) this.diagrams?.show(message.wires, this.timeOf(message.tick - 1));
  }

  /** @param {number} part */
  progress(part) {
    this.long = true;
    this.say(`running: ${Math.round(100 * part)} %`);
    if (this.again) {
      this.again = false;
      this.run();
    }
  }

  /** @param {any} message */
  done(message) {
    this.waiting = this.long = false;
    this.measures = message.measures;
    this.charts?.draw(message.pictures, this.spectra);
    this.showMeasures();
    const short = message.ticks < message.wanted && !message.fault ? "; the memory of a page holds no more" : "";
    const ran = `${message.ticks.toLocaleString("en")} ticks in ${Number(message.milliseconds.toPrecision(3))} ms${short}`;
    this.status.dataset.loop = String(message.loop); // milliseconds in the loop itself
    this.say(message.fault ? `stopped: ${message.fault} (${ran})` : ran, Boolean(message.fault));
    if (this.again) {
      this.again = false;
      this.run();
      return;
    }
    this.bits.textContent = "";
    if (this.peeked !== undefined) this.peek(this.timeOf(this.peeked));
    if (this.plotted.size) this.record();
    this.settling = setTimeout(() => this.settled(), SETTLED);
  }

  settled() {
    this.channel.postMessage({ kind: "digest" });
    if (this.seeds) this.channel.postMessage({ kind: "seeds", count: SEEDS, settings: this.settings() });
  }

  /** @param {string} text */
  say(text, wrong = false) {
    this.status.textContent = text;
    this.status.classList.toggle("warning", wrong);
  }

  showMeasures() {
    const { measures } = this.model?.loop ?? { measures: [] };
    if (measures.length && this.model) this.table.replaceChildren(measureTable(measures, this.model.units, this.measures, this.frozen ? this.before : null));
  }

  toml() {
    return this.model ? asToml(this.state.values, this.model.sliders) : "";
  }

  command() {
    const { file, options } = /** @type {Model} */ (this.model);
    const said = [`--samples ${this.ticks()}`, `--seed ${this.state.seed}`, ...asOptions(this.state.values)];
    return ["proofmass run", file, ...said, ...(Object.keys(this.state.values).length ? options : [])].join(" ");
  }

  /** @param {string} text */
  async copy(text) {
    if (!text) return this.say("nothing is changed");
    try {
      await navigator.clipboard.writeText(text);
      this.say("copied");
    } catch {
      this.say(text); // where the browser gives no clipboard, to be copied by hand
    }
  }
}

/** The duration that a graph has. @param {Model} model */
export function secondsOf(model) {
  const [top, bottom] = model.loop.rate;
  return String(Number((((model.ticks - 1) * bottom) / top).toPrecision(12)));
}
