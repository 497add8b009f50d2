// The live part of a page: controls beside plots, kept in step with a worker that runs the loop.

import { Charts } from "./charts.mjs";
import { Controls, asOptions, asToml, element } from "./controls.mjs";
import { shown, ticksOf } from "./figures.mjs";
import { Diagrams } from "./diagrams.mjs";

/**
 * @typedef {{name: string, file: string, seed: string, ticks: number, loop: import("./engine.mjs").Loop,
 *   sliders: import("./controls.mjs").Slider[], fixed: import("./controls.mjs").Fixed[],
 *   units: Record<string, import("./figures.mjs").Scales>, options: string[]}} Model
 * @typedef {{values: Record<string, number>, seed: string, duration: string}} State  of the controls
 */

const SETTLED = 250; // milliseconds without a change, after which bits are hashed

export class View {
  /** @param {HTMLElement} place @param {() => {postMessage: (wish: any) => void, listen: (hear: (message: any) => void) => void}} makeChannel
   * @param {(state: State) => void} told  hears of every change that a person makes */
  constructor(place, makeChannel, told = () => {}) {
    this.place = place;
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
    this.button("Reset", "Go back to the values of the graph", () => this.reset());
    this.button("Copy TOML", "Copy the changed parameters as lines of a graph file", () => this.copy(this.toml()));
    this.button("Copy command", "Copy the command that computes these bits", () => this.copy(this.command()));
    this.status = element("p", { className: "status" });
    this.status.setAttribute("role", "status");
    this.bits = element("p", { className: "bits soft" });
    this.table = element("div", { className: "wide measures" });
    this.plots = element("div", { className: "plots" });
    this.main.append(this.buttons, this.status, this.bits, this.table, this.plots);
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
    const old = this.model, names = new Set(model.sliders.map((one) => `${one.block}.${one.parameter}`));
    this.model = model;
    const kept = Object.entries(this.state.values).filter(([name]) => names.has(name));
    const duration = (old && this.state.duration !== secondsOf(old)) ? this.state.duration : secondsOf(model);
    const seed = old && this.state.seed !== old.seed ? this.state.seed : model.seed;
    this.state = { values: Object.fromEntries(kept), seed, duration };
    const asked = decodeURIComponent(location.hash.slice(1)); // report.html#controller
    const open = new Set(old ? [...this.list.querySelectorAll("details[open] > summary")].map((one) => one.textContent) : [asked]);
    this.list.replaceChildren();
    this.controls = new Controls(this.list, model.sliders, model.fixed, model.units, (name, value) => this.set(name, value));
    for (const group of this.list.querySelectorAll("details")) group.open = open.has(group.querySelector("summary")?.textContent ?? "");
    Controls.filter(this.list, this.filter.value);
    this.charts?.remove();
    this.charts = new Charts(this.plots, model.loop.probes, model.units, (range) => this.zoomTo(range), (time) => this.peek(time));
    this.show();
    this.diagrams = new Diagrams(model.loop.wires, model.units);
    this.waiting = this.again = false;
    this.channel.postMessage({ kind: "open", loop: model.loop });
    this.run();
  }

  show() {
    this.controls?.show(this.state.values);
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
    const slider = this.model?.sliders.find((one) => `${one.block}.${one.parameter}` === name);
    const values = { ...this.state.values, [name]: value };
    if (slider?.value === value) delete values[name];
    this.change({ ...this.state, values });
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
    const settings = { values: this.state.values, seed: this.state.seed, run: 0, ticks: 0 };
    this.channel.postMessage({ kind: "peek", tick: this.peeked, settings });
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
    if (this.waiting && !this.long) {
      this.again = true;
      return;
    }
    this.waiting = true;
    this.number += 1;
    const settings = { values: this.state.values, seed: this.state.seed, run: 0, ticks: this.ticks() };
    this.channel.postMessage({ kind: "run", number: this.number, settings, view: this.view() });
  }

  /** @param {any} message */
  hear(message) {
    if (message.kind === "failed") this.say(message.text, true);
    else if (message.kind === "progress") this.progress(message.part);
    else if (message.kind === "pictures") this.charts?.draw(message.pictures, this.spectra);
    else if (message.kind === "peek") this.diagrams?.show(message.wires, this.timeOf(message.tick));
    else if (message.kind === "digest") this.bits.textContent = message.text && `SHA-256 of the traces: ${message.text}`;
    else if (message.kind === "done" && message.number === this.number) this.done(message);
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
    this.say(message.fault ? `stopped: ${message.fault} (${ran})` : ran, Boolean(message.fault));
    if (this.again) {
      this.again = false;
      this.run();
      return;
    }
    this.bits.textContent = "";
    if (this.peeked !== undefined) this.peek(this.timeOf(this.peeked));
    this.settling = setTimeout(() => this.channel.postMessage({ kind: "digest" }), SETTLED);
  }

  /** @param {string} text */
  say(text, wrong = false) {
    this.status.textContent = text;
    this.status.classList.toggle("warning", wrong);
  }

  showMeasures() {
    const measures = this.model?.loop.measures ?? [];
    if (!measures.length || !this.model) return;
    const units = this.model.units;
    const table = element("table"), head = table.createTHead().insertRow(), body = table.createTBody();
    for (const text of ["measure", "value", ...(this.frozen ? ["frozen", "change"] : []), ""])
      head.append(element("th", { textContent: text }));
    for (const measure of measures) {
      const row = body.insertRow(), scales = units[measure.unit];
      const value = this.measures[measure.name], old = this.before[measure.name];
      row.append(element("th", { textContent: measure.name }));
      row.insertCell().textContent = shown(value, scales);
      if (this.frozen) row.insertCell().textContent = shown(old, scales);
      if (this.frozen) row.insertCell().textContent = old ? `${(100 * (value / old - 1)).toFixed(2).replace("-", "−")} %` : "";
      row.insertCell().textContent = `${measure.statistic} of ${measure.signal}`;
    }
    this.table.replaceChildren(table);
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

/** @param {HTMLElement} place @param {string} text @param {string} id */
function labelled(place, text, id) {
  const row = element("div", { className: "parameter" });
  const field = element("input", { id, type: "text", autocomplete: "off", spellcheck: false });
  row.append(element("label", { textContent: text, htmlFor: id }), field);
  place.append(row);
  return field;
}
