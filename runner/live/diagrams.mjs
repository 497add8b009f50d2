// The block diagram as a map: pan, zoom, subgraphs that unfold, overlays, and what the wires hold.

import { element } from "./controls.mjs";
import { unpacked } from "./modules.mjs";
import { shown, timeText } from "./figures.mjs";
import { pinched } from "./gestures.mjs";
import { flagsOf, signalsOf, startOf } from "./wires.mjs";

const STEP = 1.25; // of one zoom
const CLOSEST = 8;
const SLACK = 4; // pixels that a click may move
const OVERLAYS = ["rates", "loops", "formats"];
const READY = "click a block to open it, a wire to plot it; drag to move, Ctrl and wheel to zoom";

/** @typedef {import("./figures.mjs").Scales} Scales */
/** @typedef {import("./engine.mjs").Wire} Wire */
/** @typedef {{line: SVGTextElement, before: string, was: string | null}} Line  `was` is null for one that was added */

/** A picture as SVG; its text is only ever parsed as SVG, and scripts in it are not allowed to run.
 * @param {string} text */
export function drawn(text) {
  const root = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
  const figure = element("div", { className: "wide" });
  if (root.localName === "svg") figure.append(document.importNode(root, true));
  return figure;
}

export class Diagrams {
  /**
   * @param {Wire[]} wires @param {Record<string, Scales>} units
   * @param {(name: string) => void} probed  hears of a wire that is clicked
   * @param {(path: string) => void} opened  hears of a block or a subgraph that is clicked
   * @param {(paths: string[]) => Promise<string>} draw  the diagram with these subgraphs unfolded; empty for none
   */
  constructor(wires, units, probed, opened, draw) {
    this.wires = new Map(wires.map((wire) => [wire.name, wire]));
    this.units = units;
    this.probed = probed;
    this.opened = opened;
    this.draw = draw;
    this.picked = ""; // path of the block that is open
    this.marked = ""; // the signal that was clicked last
    /** @type {{slider: import("./controls.mjs").Slider, text: string}[]} */
    this.moved = [];
    /** @type {Record<string, number>} */
    this.values = {};
    this.seconds = NaN;
    /** @type {Set<string>} */
    this.unfolded = new Set();
    this.overlay = "";
    this.maps = [...document.querySelectorAll("svg.proofmass")].map((one) => new DiagramMap(/** @type {SVGSVGElement} */ (one), this));
  }

  /** Write at each wire what it holds. @param {Record<string, number>} values @param {number} seconds */
  show(values, seconds) {
    this.values = values;
    this.seconds = seconds;
    for (const map of this.maps) map.write();
  }

  /** Show which block is open. @param {string} path */
  pick(path) {
    this.picked = path;
    for (const map of this.maps) {
      map.dress();
      map.bringIntoView(path);
    }
  }

  /** Mark all wires and tabs of a signal; none if it is marked already. @param {string} signal */
  mark(signal) {
    this.marked = this.marked === signal ? "" : signal;
    for (const map of this.maps) map.dress();
  }

  /** Write into the blocks what the sliders say.
   * @param {{slider: import("./controls.mjs").Slider, text: string}[]} moved */
  tell(moved) {
    this.moved = moved;
    for (const map of this.maps) map.tell();
  }

  /** Fold or unfold a subgraph; what is inside it folds with it. @param {string} path */
  async turn(path) {
    const wanted = new Set(this.unfolded);
    const inside = [...wanted].filter((one) => `${one}.`.startsWith(`${path}.`));
    if (inside.length) for (const one of inside) wanted.delete(one);
    else path.split(".").forEach((_, i, words) => wanted.add(words.slice(0, i + 1).join(".")));
    await this.unfold(wanted, path);
  }

  /** @param {Set<string>} wanted @param {string} newest */
  async unfold(wanted, newest = "") {
    let text = await this.draw([...wanted].sort());
    if (!text && newest) {
      wanted = new Set(newest.split(".").map((_, i, words) => words.slice(0, i + 1).join(".")));
      text = await this.draw([...wanted].sort()); // a page without a process carries one at a time, or all
    }
    if (!text) return;
    this.unfolded = wanted;
    for (const map of this.maps) {
      map.replace(text);
      map.bringIntoView(newest);
    }
  }

  /** @param {string} name */
  lay(name) {
    this.overlay = this.overlay === name ? "" : name;
    for (const map of this.maps) map.dress();
  }

  /** What is known of a signal. @param {string} name */
  about(name) {
    const wire = this.wires.get(name), value = this.values[name];
    if (!wire) return name;
    const now = value === undefined ? "" : ` = ${shown(value, this.units[wire.unit], 6)} at ${timeText(this.seconds)}`;
    return `${name}${now}${wire.doc ? `: ${wire.doc}` : ""}`;
  }
}

class DiagramMap {
  /** @param {SVGSVGElement} drawing @param {Diagrams} all */
  constructor(drawing, all) {
    this.drawing = drawing;
    this.all = all;
    this.place = /** @type {HTMLElement} */ (drawing.parentElement);
    this.width = this.height = this.zoom = 1;
    this.x = this.y = this.moved = 0;
    this.bar = /** @type {HTMLElement} */ (this.place.querySelector(".map-bar") ?? this.makeBar());
    this.bar.replaceChildren();
    for (const [text, title, factor] of /** @type {[string, string, number][]} */ ([["+", "Zoom in", STEP], ["−", "Zoom out", 1 / STEP], ["fit", "Show all of it", 0]]))
      this.button(text, title, () => this.zoomAt(factor));
    this.overlays = OVERLAYS.map((name) => this.button(name, `Colour ${name === "formats" ? "types and fixed-point formats" : name}`, () => this.all.lay(name)));
    if (drawing.querySelector(".fold")) {
      this.button("unfold all", "Show what is inside every subgraph", () => void this.unfoldAll());
      this.button("fold all", "Show subgraphs as boxes", () => void this.all.unfold(new Set()));
    }
    /** Numbers that are written over the picture, by slider. @type {Map<string, Line | null>} */
    this.lines = new Map();
    this.line = element("span", { className: "map-time soft", textContent: READY });
    this.line.setAttribute("role", "status");
    this.bar.append(this.line);
    this.begin();
  }

  makeBar() {
    const bar = element("div", { className: "map-bar" });
    this.place.prepend(bar);
    return bar;
  }

  /** @param {string} text @param {string} title @param {() => void} act */
  button(text, title, act) {
    const made = element("button", { type: "button", textContent: text, title });
    made.addEventListener("click", act);
    this.bar.append(made);
    return made;
  }

  begin() {
    const { drawing } = this, whole = drawing.viewBox.baseVal;
    this.width = whole.width;
    this.height = whole.height;
    this.zoom = 1;
    this.x = this.y = this.moved = 0;
    this.lines.clear();
    drawing.classList.add("map");
    this.dress();
    drawing.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    drawing.addEventListener("pointerdown", () => (this.moved = 0));
    drawing.addEventListener("pointermove", (event) => this.move(event));
    drawing.addEventListener("pointerover", (event) => this.hover(event));
    drawing.addEventListener("click", (event) => this.click(event));
    pinched(drawing, (factor, across, down) => this.zoomAt(factor, across, down));
    drawing.setAttribute("role", "group"); // of buttons: a picture has none
    for (const block of drawing.querySelectorAll("[data-block]")) {
      block.setAttribute("tabindex", "0");
      block.setAttribute("role", "button");
      block.setAttribute("aria-label", `block ${block.getAttribute("data-block")}`);
    }
    drawing.addEventListener("keydown", (event) => {
      if (!["Enter", " "].includes(event.key)) return;
      event.preventDefault();
      this.click(event);
    });
    this.write();
    this.tell();
  }

  /** Draw anew. @param {string} text */
  replace(text) {
    const next = drawn(text).firstElementChild;
    if (!(next instanceof SVGSVGElement)) return;
    this.drawing.replaceWith(next);
    this.drawing = next;
    this.begin();
    next.dispatchEvent(new Event("drawn", { bubbles: true }));
  }

  async unfoldAll() {
    for (let known = -1; known !== this.all.unfolded.size; ) {
      known = this.all.unfolded.size;
      const paths = [...this.drawing.querySelectorAll("[data-part]")].map((one) => one.getAttribute("data-part") ?? "");
      const all = new Set([...this.all.unfolded, ...paths]);
      const text = await this.all.draw(["*"]) || await this.all.draw([...all].sort());
      if (!text) return;
      this.replace(text);
      this.all.unfolded = new Set([...this.drawing.querySelectorAll(".open[data-part]")].map((one) => one.getAttribute("data-part") ?? ""));
    }
  }

  /** Show the overlay that is chosen. */
  dress() {
    for (const name of OVERLAYS) this.drawing.classList.toggle(name, name === this.all.overlay);
    for (const block of this.drawing.querySelectorAll("[data-block]"))
      block.classList.toggle("picked", block.getAttribute("data-block") === this.all.picked);
    for (const wire of /** @type {NodeListOf<SVGGElement>} */ (this.drawing.querySelectorAll("[data-signal], [data-net]")))
      wire.classList.toggle("marked", this.all.marked !== "" && this.all.marked === (wire.dataset.signal ?? wire.dataset.net));
    this.overlays.forEach((made, i) => made.setAttribute("aria-pressed", String(OVERLAYS[i] === this.all.overlay)));
  }

  settle() {
    this.x = Math.min(Math.max(0, this.x), this.width - this.width / this.zoom);
    this.y = Math.min(Math.max(0, this.y), this.height - this.height / this.zoom);
    this.drawing.setAttribute("viewBox", `${this.x} ${this.y} ${this.width / this.zoom} ${this.height / this.zoom}`);
    this.drawing.classList.toggle("zoomed", this.zoom > 1);
  }

  /** @param {number} factor */
  zoomAt(factor, across = 0.5, down = 0.5) {
    const next = Math.min(CLOSEST, Math.max(1, this.zoom * factor));
    this.x += across * (this.width / this.zoom - this.width / next);
    this.y += down * (this.height / this.zoom - this.height / next);
    this.zoom = next;
    this.settle();
  }

  /** @param {WheelEvent} event */
  wheel(event) {
    if (!event.ctrlKey) return;
    event.preventDefault();
    const box = this.drawing.getBoundingClientRect();
    this.zoomAt(event.deltaY < 0 ? STEP : 1 / STEP, (event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
  }

  /** @param {PointerEvent} event */
  move(event) {
    if (!event.buttons) return;
    this.moved += Math.abs(event.movementX) + Math.abs(event.movementY);
    if (this.zoom === 1) {
      if (event.pointerType === "touch") return; // the browser scrolls
      this.place.scrollLeft -= event.movementX; // a picture wider than the page
      this.place.scrollTop -= event.movementY;
      return;
    }
    const scale = this.width / this.zoom / this.drawing.getBoundingClientRect().width;
    this.x -= event.movementX * scale;
    this.y -= event.movementY * scale;
    this.settle();
  }

  /** @param {Event} event */
  hover(event) {
    const signals = signalsOf(/** @type {Element} */ (event.target));
    if (signals.length) this.line.textContent = signals.map((name) => this.all.about(name)).join("; ");
    else this.line.textContent = Number.isFinite(this.all.seconds) ? this.time() : READY;
  }

  /** @param {Event} event */
  click(event) {
    if (event.type === "click" && this.moved > SLACK) return;
    const target = /** @type {Element} */ (event.target);
    const fold = target.closest("[data-fold]")?.getAttribute("data-fold");
    const signals = signalsOf(target);
    const block = target.closest("[data-block]")?.getAttribute("data-block");
    if (fold) void this.all.turn(fold);
    else if (signals.length) {
      if (signals.length === 1) this.all.mark(signals[0]);
      for (const signal of signals) this.all.probed(signal);
    }
    else if (block) this.all.opened(block);
  }

  /** Write the numbers of sliders that were moved over those of the file, or below a block that does not show them. */
  tell() {
    const { moved } = this.all, names = moved.map(({ slider }) => `${slider.block}.${slider.parameter}`);
    if (names.length !== this.lines.size || !names.every((name) => this.lines.has(name))) this.restore();
    moved.forEach(({ slider, text }, i) => {
      if (!this.lines.has(names[i])) this.lines.set(names[i], this.lineOf(slider));
      const place = this.lines.get(names[i]), told = `${place?.before ?? ""}${text}`;
      if (place && place.line.textContent !== told) place.line.textContent = told; // else nothing is drawn anew
    });
  }

  /** Write what the file says. */
  restore() {
    for (const place of this.lines.values()) {
      if (place?.was === null) place.line.remove();
      else if (place) place.line.textContent = place.was;
      place?.line.classList.remove("now");
    }
    this.lines.clear();
  }

  /** The place of a slider's number. @param {import("./controls.mjs").Slider} slider @returns {Line | null} */
  lineOf({ block, parameter, drawn }) {
    const group = this.groupOf(block), path = group?.getAttribute("data-block") ?? "", own = path === block;
    if (!group) return null;
    /** @type {NodeListOf<SVGTextElement>} */
    const settings = group.querySelectorAll(":scope > .setting:not(.now)"), known = [`${parameter} ${drawn}`, drawn];
    const row = own && [...settings].find((one) => known.includes(one.textContent ?? ""));
    if (!row) return { line: this.below(group), before: `${own ? "" : `${block.slice(path.length + 1)}.`}${parameter} `, was: null };
    const was = row.textContent ?? "";
    row.classList.add("now");
    return { line: row, before: was.startsWith(`${parameter} `) ? `${parameter} ` : "", was };
  }

  /** The block, or the subgraph around it that is folded. @param {string} path */
  groupOf(path) {
    for (let name = path; name; name = name.slice(0, Math.max(0, name.lastIndexOf(".")))) {
      const group = this.drawing.querySelector(`[data-block="${CSS.escape(name)}"]`);
      if (group) return /** @type {SVGGElement} */ (group);
    }
    return null;
  }

  /** Scroll the map, not the page, to a block that is out of sight. @param {string} path */
  bringIntoView(path) {
    const group = path && this.groupOf(path);
    if (!group) return;
    const block = group.getBoundingClientRect(), seen = this.place.getBoundingClientRect();
    const off = (/** @type {number[]} */ [first, last], /** @type {number[]} */ [from, to]) => {
      if (first >= from && last <= to) return 0;
      return last - first > to - from ? first - from : (first + last - from - to) / 2; // its start, or its middle
    };
    this.place.scrollLeft += off([block.left, block.right], [seen.left, seen.right]);
    this.place.scrollTop += off([block.top, block.bottom], [seen.top + this.bar.offsetHeight, seen.bottom]);
  }

  /** A line below a block. @param {SVGGElement} group */
  below(group) {
    const area = group.querySelector(":scope > .area") ?? group.querySelector(":scope > .box");
    const frame = /** @type {SVGGraphicsElement} */ (area);
    const { x, y, width, height } = frame.getBBox(), above = group.querySelectorAll(":scope > text.now.below").length;
    const line = document.createElementNS("http://www.w3.org/2000/svg", "text");
    line.setAttribute("class", "setting now below");
    line.setAttribute("x", String(x + width / 2));
    line.setAttribute("y", String(y + height + 13 * (above + 1)));
    line.setAttribute("text-anchor", "middle");
    group.append(line);
    return line;
  }

  time() {
    return `values at ${timeText(this.all.seconds)}`;
  }

  write() {
    const { values, units, wires, seconds } = this.all;
    for (const old of this.drawing.querySelectorAll(".peek")) old.remove();
    this.drawing.classList.toggle("peeking", Number.isFinite(seconds));
    if (!Number.isFinite(seconds)) return;
    const flags = flagsOf(this.drawing);
    this.line.textContent = this.time();
    /** @type {Set<string>} */
    const known = new Set();
    for (const wire of /** @type {NodeListOf<SVGGElement>} */ (this.drawing.querySelectorAll("[data-signal]"))) {
      const name = wire.dataset.signal ?? "", about = wires.get(name), start = startOf(wire);
      const place = start && `${name} ${start.x} ${start.y}`;
      if (!about || values[name] === undefined || !start || known.has(String(place))) continue;
      known.add(String(place));
      const made = document.createElementNS("http://www.w3.org/2000/svg", "text");
      made.setAttribute("class", "peek");
      made.setAttribute("data-of", name);
      made.setAttribute("text-anchor", start.way < 0 ? "end" : "start");
      const past = flags.get(`${start.x} ${start.y}`) ?? 0;
      made.setAttribute("x", String(start.x + (past + 4) * start.way));
      made.setAttribute("y", String(start.y - 4));
      made.textContent = shown(values[name], units[about.unit], 5);
      (wire.parentElement ?? wire).append(made);
    }
  }
}

/** Diagrams that a page carries, packed, as the function that draws them. @param {string | undefined} text
 * @returns {(paths: string[]) => Promise<string>} */
export function carriedDrawings(text) {
  /** @type {Record<string, string> | null} */
  let drawings = null;
  const folded = document.querySelector("svg.proofmass")?.outerHTML ?? "";
  return async (paths) => {
    if (!paths.length) return folded;
    drawings ??= text ? JSON.parse(new TextDecoder().decode(await unpacked(text))) : {};
    const known = /** @type {Record<string, string>} */ (drawings);
    if (paths[0] === "*") return Object.entries(known).reduce((most, one) => (one[0].length > most[0].length ? one : most), ["", ""])[1];
    return known[paths.join(",")] ?? "";
  };
}
