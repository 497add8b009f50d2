// The live part of a page: controls beside plots, kept in step with a worker that runs the loop.

import { Charts } from "./charts.mjs";
import { Controls, element, labelled, nameOf } from "./controls.mjs";
import { Diagrams, carriedDrawings } from "./diagrams.mjs";
import { timeText } from "./figures.mjs";
import { Fields } from "./fields.mjs";
import { Leading } from "./leading.mjs";
import { TOO_LONG, askForLong } from "./long.mjs";
import { measureTable } from "./measures.mjs";
import { plot } from "./plotted.mjs";
import { Picked } from "./picked.mjs";
import { arrange, takeIn } from "./places.mjs";
import { ticksOf } from "./quantities.mjs";
import { command, copy, ticksIn, toml } from "./said.mjs";
import { SEEDS, Seeds } from "./seeds.mjs";
import { Strip } from "./strip.mjs";
import { parametersOf } from "./values.mjs";

/**
 * @typedef {{name: string, file: string, seed: string, ticks: number, loop: import("./engine.mjs").Loop,
 *   sliders: import("./controls.mjs").Slider[], fixed: import("./controls.mjs").Fixed[],
 *   units: Record<string, import("./figures.mjs").Scales>, options: string[], named: import("./values.mjs").Named,
 *   order: string[], duration: string, blocks: Record<string, import("./picked.mjs").Block>,
 *   kinds: Record<string, import("./picked.mjs").Kind>, spelled: Record<string, import("./quantities.mjs").Spelled>,
 *   loops: string[], required: import("./strip.mjs").Required[], drawings?: string}} Model
 * @typedef {{values: Record<string, number>, seed: string, duration: string}} State  of the controls
 * @typedef {{ask: (name: string, text: string) => void, draw: (paths: string[]) => Promise<string>,
 *   long: (wish: any) => void, judge: (state: State, thorough: boolean) =>
 *   Promise<import("./strip.mjs").Answer | null>}} Process
 *   that takes what the loop does not take anew, draws, does long runs, and knows margins
 */

const TRACES_FIRST = 100; // milliseconds that verdicts of a new graph wait
const SHORT_WALK = 20; // ticks that are shown at least
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
    this.waiting = this.again = false; // for a run; another one is wanted after it
    /** @type {Record<string, number>} */
    this.measures = {};
    /** @type {Record<string, number>} */
    this.before = {};
    /** @type {Set<string>} */
    this.plotted = new Set(); // wires that are recorded besides the probes
    this.note = ""; // of what was saved, until something changes
    this.top = element("div", { className: "top" });
    place.replaceChildren(this.top);
    place.hidden = false;
    document.body.classList.add("bench"); // a rule with :has would be asked again at each change of the page
    this.strip = new Strip(this.place, (text) => this.say(text));
    this.map = element("div", { className: "map" });
    this.side = element("div", { className: "side" });
    this.main = element("div", { className: "main" });
    this.place.append(this.map, this.side, this.main);
    if (!process) takeIn(place, this.map);
    this.map.addEventListener("drawn", () => arrange(place));
    this.filter = labelled(this.side, "find", "run-find");
    this.filter.type = "search";
    this.list = element("div", { className: "blocks" });
    this.picked = new Picked(this.side, this.main, () => this.pick(""));
    this.side.append(this.list, this.picked.more);
    this.buttons = element("div", { className: "buttons run" });
    this.freezing = this.button("Freeze", "Keep this run to compare with", () => this.freeze(!this.frozen));
    this.kind = this.button("Spectra", "Show densities of what is seen", () => this.showSpectra(!this.spectra));
    this.many = this.button("Seeds", `Show the measures of ${SEEDS} seeds`, () => this.seeds.show(!this.seeds.on));
    this.walking = this.button("Walk", "Go through the run tick by tick, from the time that was clicked", () => this.leading.toggle());
    this.button("Reset", "Go back to the values of the graph", () => this.reset());
    this.button("Copy TOML", "Copy the changed parameters as lines of a graph file", () => copy(this, toml(this)));
    this.button("Copy command", "Copy the command that computes these bits", () => copy(this, command(this)));
    this.status = element("p", { className: "status" });
    this.status.setAttribute("role", "status");
    this.bits = element("p", { className: "bits soft" });
    this.table = element("div", { className: "wide measures" });
    this.seeds = new Seeds(this);
    this.plots = element("div", { className: "plots" });
    this.top.append(this.buttons);
    this.fields = new Fields(this.top, this);
    this.top.append(this.status);
    this.leading = new Leading(this.main, this.channel, () => this.startOfWalk(), (tick) => this.timeOf(tick), () => this.run());
    this.main.append(this.seeds.place, this.plots, this.table, this.bits);
    this.filter.addEventListener("input", () => Controls.filter(this.list, this.filter.value));
    document.addEventListener("keydown", (event) => event.key === "Escape" && this.picked.path && this.pick(""));
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
    const old = this.model, picked = this.picked.path, { sliders, fixed, spelled } = model;
    this.model = model;
    const own = new Map(sliders.map((slider) => [nameOf(slider), slider.value]));
    const kept = Object.entries(this.state.values).filter(([name, value]) => (own.get(name) ?? value) !== value);
    const duration = (old && this.state.duration !== old.duration) ? this.state.duration : model.duration;
    const seed = old && this.state.seed !== old.seed ? this.state.seed : model.seed;
    this.state = { values: Object.fromEntries(kept), seed, duration };
    const asked = decodeURIComponent(location.hash.slice(1)); // report.html#controller
    const open = new Set(old ? [...this.list.querySelectorAll("details[open] > summary")].map((one) => one.textContent) : [asked]);
    this.list.replaceChildren();
    const set = (/** @type {string} */ name, /** @type {number} */ value) => this.set(name, value);
    this.controls = new Controls(this.list, sliders, fixed, spelled, set, this.process?.ask ?? null);
    for (const group of this.list.querySelectorAll("details")) {
      const block = group.querySelector("summary")?.textContent ?? "";
      group.open = open.has(block) || (!old && block === "values");
    }
    Controls.filter(this.list, this.filter.value);
    this.charts?.remove();
    const place = (/** @type {{signal: string}} */ { signal }) => model.order.indexOf(signal);
    const probes = [...model.loop.probes].sort((a, b) => place(a) - place(b));
    this.charts = new Charts(this.plots, probes, model.units, (range) => this.zoomTo(range), (time) => this.peek(time));
    this.show();
    this.lookAtDiagrams();
    const wanted = old ? picked : asked;
    this.pick(Object.keys(model.blocks).some((name) => `${name}.`.startsWith(`${wanted}.`)) ? wanted : "");
    this.strip.bar.classList.toggle("waiting", this.process !== null);
    setTimeout(() => this.judge(), TRACES_FIRST);
    const plotted = [...this.plotted];
    this.plotted.clear();
    for (const name of plotted) plot(this, name);
    if (this.leading.on) this.leading.toggle();
    this.waiting = this.again = false;
    this.channel.postMessage({ kind: "open", loop: model.loop });
    this.run();
  }

  /** Take the diagrams that the page has as maps, unfolded and coloured as those before were. */
  lookAtDiagrams() {
    if (!this.model) return;
    const { loop, units, drawings } = this.model, { unfolded, overlay = "", values, seconds } = this.diagrams ?? {};
    const draw = this.process?.draw ?? carriedDrawings(drawings);
    this.diagrams = new Diagrams(loop.wires, units, (name) => plot(this, name), (path) => this.pick(path), draw);
    arrange(this.place);
    this.diagrams.pick(this.picked.path);
    this.diagrams.tell(this.controls?.moved() ?? []);
    if (unfolded?.size) void this.diagrams.unfold(unfolded);
    if (overlay) this.diagrams.lay(overlay);
    if (values && seconds !== undefined) this.diagrams.show(values, seconds);
  }

  /** Open a block beside the diagram: its controls, scopes of its ports, its equation. @param {string} path */
  pick(path) {
    if (!this.model) return;
    this.picked.open(path, this.model, (range) => this.zoomTo(range), (time) => this.peek(time));
    Controls.pick(this.list, path);
    this.place.classList.toggle("picking", path !== "");
    /** @type {HTMLElement} */ (this.filter.parentElement).hidden = path !== "";
    this.diagrams?.pick(path);
    this.record();
  }

  judge() {
    const { process, model } = this;
    this.strip.look(model?.loops ?? [], process && ((thorough) => process.judge(this.state, thorough)));
  }

  /** Parameters of a run: those that were set, and those that follow from named values. */
  parameters() {
    return this.model ? parametersOf(this.model.named, this.state.values) : {};
  }

  show() {
    this.controls?.show(this.state.values, this.parameters());
    this.diagrams?.tell(this.controls?.moved() ?? []);
    this.fields.show(this.state);
  }

  /** Take over what another window says. @param {State} state */
  follow(state) {
    this.state = state;
    this.show();
    this.run();
    this.judge();
  }

  /** @param {string} name @param {number} value */
  set(name, value) {
    const slider = this.model?.sliders.find((one) => nameOf(one) === name);
    const values = { ...this.state.values, [name]: value };
    if (slider?.value === value) delete values[name];
    this.change({ ...this.state, values });
    if (slider?.named) this.show(); // others follow
    else this.diagrams?.tell(this.controls?.moved() ?? []);
  }

  /** @param {State} state */
  change(state) {
    this.state = state;
    this.note = "";
    this.told(state);
    this.run();
    this.judge();
  }

  reset() {
    if (!this.model) return;
    this.zoom = null;
    this.change({ values: {}, seed: this.model.seed, duration: this.model.duration });
    this.show();
  }

  /** @param {[number, number] | null} range */
  zoomTo(range) {
    const whole = this.seconds(), width = range ? Math.min(whole, range[1] - range[0]) : whole;
    const first = range ? Math.max(0, Math.min(range[0], whole - width)) : 0;
    this.zoom = width < whole ? [first, first + width] : null;
    this.channel.postMessage({ kind: "view", view: this.view() });
  }

  /** Show what the wires hold at a time. @param {number} seconds */
  peek(seconds) {
    const [top, bottom] = this.model?.loop.rate ?? [1, 1];
    const tick = Math.floor((seconds * top) / bottom + 1e-6);
    this.peeked = Math.min(Math.max(0, tick), this.ticks() - 1);
    for (const charts of [this.charts, this.picked.charts]) charts?.mark(this.timeOf(this.peeked));
    this.channel.postMessage({ kind: "peek", tick: this.peeked, settings: { ...this.settings(), ticks: 0 } });
  }

  settings() {
    return { values: this.parameters(), seed: this.state.seed, run: 0, ticks: this.ticks() };
  }

  startOfWalk() {
    this.channel.postMessage({ kind: "record", names: [] });
    return { tick: this.peeked ?? 0, settings: this.settings(), view: this.view() };
  }

  record() {
    const names = [...new Set([...this.plotted, ...this.picked.signals])];
    this.channel.postMessage({ kind: "record", names, settings: this.settings() });
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

  /** Ticks of a duration as text; null for what is none. @param {string} text */
  ticksIn(text) {
    return this.model ? ticksOf(text, this.model.loop.rate, this.model.spelled.s) : 0;
  }

  ticks() {
    return this.ticksIn(this.state.duration) ?? this.model?.ticks ?? 0;
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
    else if (message.kind === "pictures") this.draw(message.pictures);
    else if (message.kind === "wires") this.draw([], message.pictures);
    else if (message.kind === "peek") this.diagrams?.show(message.wires, this.timeOf(message.tick));
    else if (message.kind === "seeds") this.seeds.hear(message);
    else if (message.kind === "walk" && this.leading.on) this.walked(message);
    else if (message.kind === "digest") this.bits.textContent = message.text && `SHA-256 of the traces: ${message.text}`;
    else if (message.kind === "done" && message.number === this.number) this.done(message);
  }

  /** @param {any} pictures  of probes @param {any} wires  that are recorded besides */
  draw(pictures, wires = []) {
    const { first, last: end } = this.view(), stretch = this.zoom ? `${timeText(first, 3)} to ${timeText(end, 3)}` : "";
    const walked = this.leading.on && !this.zoom ? this.timeOf(Math.max(SHORT_WALK, this.leading.tick)) : end;
    const last = Math.min(end, walked);
    for (const charts of [this.charts, this.picked.charts]) {
      if (charts) charts.range = [first, Math.max(last, Number.MIN_VALUE)];
      charts?.drawWires(wires);
    }
    this.charts?.draw(pictures, this.spectra, stretch);
  }

  /** @param {any} message */
  walked(message) {
    this.leading.hear(message);
    this.bits.textContent = "";
    this.draw(message.pictures);
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
    this.measures = message.measures;
    this.draw(message.pictures);
    queueMicrotask(() => this.finish(message)); // after the plots: letters that are drawn ask for styles, which words change
  }

  /** @param {any} message */
  finish(message) {
    this.waiting = this.long = false;
    this.showMeasures();
    const ran = `${this.note}${ticksIn(message)}`;
    this.status.dataset.loop = String(message.loop); // milliseconds in the loop itself
    this.say(message.fault ? `stopped: ${message.fault} (${ran})` : ran, Boolean(message.fault));
    if (this.again) {
      this.again = false;
      return this.run();
    }
    this.bits.textContent = "";
    if (this.peeked !== undefined) this.peek(this.timeOf(this.peeked));
    if (this.plotted.size + this.picked.signals.length) this.record();
    this.settling = setTimeout(() => this.settled(), SETTLED);
  }

  settled() {
    this.channel.postMessage({ kind: "digest" });
    if (this.seeds.on) this.seeds.ask();
  }

  /** @param {string} text */
  say(text, wrong = false) {
    this.status.textContent = text;
    this.status.classList.toggle("warning", wrong);
  }

  showMeasures() {
    if (!this.model) return;
    const { loop: { measures }, units, required } = this.model;
    const scales = new Map(measures.map(({ name, unit }) => [name, units[unit]]));
    this.strip.measure(required, this.measures, scales);
    const before = this.frozen ? this.before : null;
    if (measures.length) this.table.replaceChildren(measureTable(measures, units, this.measures, before));
  }
}
