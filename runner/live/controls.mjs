// Fields and sliders: one for each parameter, folded by block, and what the command line is told about them.

import { nearest, numberIn, quantity, textIn } from "./quantities.mjs";

/**
 * @typedef {import("./quantities.mjs").Spelled} Spelled
 * @typedef {{block: string, parameter: string, unit: string, doc: string, value: number, low: number, high: number,
 *   logarithmic: boolean, above: number | null, at_least: number | null, below: number | null,
 *   at_most: number | null, named: boolean, written: string, drawn: string, shown: string, printed: string,
 *   factor: [string, string]}} Slider
 * @typedef {{block: string, parameter: string, unit: string, doc: string, value: string, named: boolean,
 *   choices: string[], whole: boolean}} Fixed
 */

const STEPS = 1000;
const SHOWN = 6; // digits in a diagram
const DIGITS = 4, ENDS = 3; // of what a slider sets, and of the ends of its range

export class Controls {
  /**
   * @param {HTMLElement} place @param {Slider[]} sliders @param {Fixed[]} fixed
   * @param {Record<string, Spelled>} spelled @param {(name: string, value: number) => void} changed
   * @param {((name: string, text: string) => void) | null} asked  of a process, for what the loop does not take anew
   */
  constructor(place, sliders, fixed, spelled, changed, asked = null) {
    /** @type {Map<string, Control>} */
    this.controls = new Map();
    const blocks = [...new Set([...sliders, ...fixed].map(({ block }) => block))].sort();
    for (const block of blocks) {
      const group = element("details", { className: "block", open: !block }), body = element("div");
      group.dataset.of = block;
      group.append(named("summary", block || "values"), body);
      for (const slider of sliders.filter((one) => one.block === block)) {
        const control = new Control(slider, spelled[slider.shown], changed);
        this.controls.set(nameOf(slider), control);
        body.append(control.row);
      }
      for (const one of fixed.filter((other) => other.block === block)) {
        const name = nameOf(one);
        body.append(asked && (one.whole || one.choices.length) ? askable(one, (text) => asked(name, text)) : still(one, asked !== null));
      }
      place.append(group);
    }
  }

  /** @param {Record<string, number>} values  as they were set @param {Record<string, number>} following  from them */
  show(values, following = {}) {
    for (const [name, control] of this.controls) control.show(values[name] ?? following[name] ?? control.slider.value);
  }

  /** Sliders that are not where the graph has them, each with its value in words. */
  moved() {
    const changed = [...this.controls.values()].filter(({ value, slider }) => value !== slider.value);
    return changed.map(({ slider, field }) => {
      const long = field.value.length > SHOWN + 2;
      const number = long ? String(Number(Number(field.value).toPrecision(SHOWN))) : field.value;
      return { slider, text: slider.printed === "1" ? number : `${number} ${slider.printed}` };
    });
  }

  /** Why a parameter is out of bounds; empty where all are within them. @param {Record<string, number>} values */
  wrong(values) {
    for (const [name, value] of Object.entries(values)) {
      const slider = this.controls.get(name)?.slider, why = slider && (Number.isFinite(value) ? outside(slider, value) : "has no value");
      if (why) return `${name} ${why}`;
    }
    return "";
  }

  /** Show the controls of one block, or of those inside a subgraph; all for an empty name. @param {HTMLElement} place
   * @param {string} path */
  static pick(place, path) {
    for (const group of place.querySelectorAll("details")) {
      const of = group.dataset.of ?? "", inside = of === path || of.startsWith(`${path}.`);
      group.hidden = path !== "" && !inside;
      if (path) group.open = inside;
    }
  }

  /** Show the blocks and parameters whose name holds a text; all for an empty one. @param {HTMLElement} place
   * @param {string} text */
  static filter(place, text) {
    const wanted = text.trim().toLowerCase();
    for (const group of place.querySelectorAll("details")) {
      const rows = [...group.querySelectorAll("[data-name]")];
      const matching = rows.filter((row) => /** @type {HTMLElement} */ (row).dataset.name?.includes(wanted));
      for (const row of rows) /** @type {HTMLElement} */ (row).hidden = !matching.includes(row);
      group.hidden = !matching.length;
      if (wanted) group.open = matching.length > 0;
    }
  }
}

class Control {
  /** @param {Slider} slider @param {Spelled} spelled @param {(name: string, value: number) => void} changed */
  constructor(slider, spelled, changed) {
    this.slider = slider;
    this.spelled = spelled;
    this.value = slider.value;
    this.unit = nearest([BigInt(slider.factor[0]), BigInt(slider.factor[1])]); // of the field, in that of the value
    const name = nameOf(slider);
    this.row = element("div", { className: "parameter" });
    this.row.dataset.name = name.toLowerCase();
    const label = named("label", slider.parameter, { title: slider.doc, htmlFor: name });
    this.field = element("input", { id: name, type: "text", autocomplete: "off", spellcheck: false });
    const range = element("input", { type: "range", min: "0", max: String(STEPS), step: "1" });
    range.setAttribute("aria-label", `${name}, slider`);
    this.range = range;
    const ends = element("div", { className: "ends" });
    ends.append(...[slider.low, slider.high].map((end) => element("span", { textContent: this.short(end) })));
    const unit = slider.shown === "1" ? "" : slider.shown;
    this.row.append(label, this.field, named("span", unit, { className: "unit" }), range, ends);
    range.addEventListener("input", () => this.set(this.valueAt(Number(range.value)), changed));
    this.field.addEventListener("change", () => this.typed(changed));
    this.show(slider.value);
  }

  /** An end of the range. @param {number} value */
  short(value) {
    return String(Number((value / this.unit).toPrecision(ENDS))).replace("-", "−");
  }

  /** @param {number} value */
  show(value) {
    this.value = value;
    const own = value === this.slider.value ? numberIn(this.slider.written) : "";
    this.field.value = own || textIn(value, this.slider.factor);
    this.field.setCustomValidity("");
    this.range.value = String(this.stepOf(value));
    this.row.classList.toggle("changed", value !== this.slider.value);
  }

  /** @param {number} value @param {(name: string, value: number) => void} changed */
  set(value, changed) {
    this.show(value);
    changed(nameOf(this.slider), value);
  }

  /** @param {(name: string, value: number) => void} changed */
  typed(changed) {
    const { slider } = this, read = quantity(this.field.value, slider.shown, slider.factor, this.spelled);
    const value = typeof read === "string" ? NaN : nearest(read);
    const wrong = typeof read === "string" ? read : outside(slider, value);
    this.field.setCustomValidity(wrong && `${slider.parameter} ${wrong}`);
    if (wrong) this.field.reportValidity();
    else this.set(value, changed);
  }

  /** A value with few digits in the unit of the field. @param {number} step */
  valueAt(step) {
    const { low, high, logarithmic, factor } = this.slider, part = step / STEPS;
    const value = logarithmic ? low * (high / low) ** part : low + (high - low) * part;
    const read = quantity((value / this.unit).toPrecision(DIGITS), "", factor, []);
    const tidy = typeof read === "string" ? value : nearest(read);
    return outside(this.slider, tidy) ? this.inside(value) : tidy;
  }

  /** A value off the ends that the parameter itself excludes. @param {number} value */
  inside(value) {
    const { low, high } = this.slider, little = (high - low) / STEPS / 10;
    return Math.min(high - little, Math.max(low + little, value));
  }

  /** @param {number} value */
  stepOf(value) {
    const { low, high, logarithmic } = this.slider;
    const part = logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    return Math.round(STEPS * Math.min(1, Math.max(0, part || 0)));
  }
}

/** Why a value is out of bounds; empty where it is within them. @param {Slider} slider @param {number} value */
function outside(slider, value) {
  const { above, at_least, below, at_most, shown } = slider;
  const said = (/** @type {number} */ end) => (end && shown !== "1" ? `${textIn(end, slider.factor)} ${shown}` : end);
  if (above !== null && !(value > above)) return `must be above ${said(above)}`;
  if (at_least !== null && !(value >= at_least)) return `must be at least ${said(at_least)}`;
  if (below !== null && !(value < below)) return `must be below ${said(below)}`;
  return at_most !== null && !(value <= at_most) ? `must be at most ${said(at_most)}` : "";
}

/** An integer or a choice, which the process takes and compiles anew. @param {Fixed} one @param {(text: string) => void} asked */
function askable(one, asked) {
  const row = element("div", { className: "parameter" }), name = nameOf(one);
  row.dataset.name = name.toLowerCase();
  const field = one.choices.length ? element("select", { id: name }) : element("input", { id: name, type: "text", inputMode: "numeric", autocomplete: "off" });
  if (field instanceof HTMLSelectElement) field.append(...one.choices.map((text) => element("option", { textContent: text, value: text })));
  field.value = one.value;
  field.addEventListener("change", () => asked(field.value.trim()));
  row.append(named("label", one.parameter, { title: one.doc, htmlFor: name }), field);
  row.append(named("span", one.unit === "1" ? "" : one.unit, { className: "unit" }));
  return row;
}

/** A parameter that needs the command line. @param {Fixed} one @param {boolean} served */
function still(one, served) {
  const how = served || !(one.whole || one.choices.length) ? "Change it in the file, or by --set." : "Change it in the file, by --set, or in proofmass live.";
  const row = element("div", { className: "parameter still", title: `${one.doc} ${how}` });
  row.dataset.name = nameOf(one).toLowerCase();
  const value = one.value.length > 24 ? `${one.value.slice(0, 22)} …` : one.value;
  row.append(named("span", one.parameter), named("span", value, { className: "value" }));
  row.append(named("span", one.unit === "1" ? "" : one.unit, { className: "unit" }));
  return row;
}

/** @param {{block: string, parameter: string}} of */
export function nameOf(of) {
  return of.block ? `${of.block}.${of.parameter}` : of.parameter;
}

/** Changes as options of the command line. @param {Record<string, number>} values */
export function asOptions(values) {
  return Object.entries(values).map(([name, value]) => `--set ${name}=${value}`);
}

/** Changes as tables of a graph file. @param {Record<string, number>} values @param {Slider[]} sliders */
export function asToml(values, sliders) {
  /** @type {Map<string, string[]>} */
  const tables = new Map();
  for (const [name, value] of Object.entries(values)) {
    const slider = sliders.find((one) => nameOf(one) === name);
    if (!slider) continue;
    const number = textIn(value, slider.factor), text = slider.shown === "1" ? number : `"${number} ${slider.shown}"`;
    tables.set(slider.block, [...(tables.get(slider.block) ?? []), `${slider.parameter} = ${text}`]);
  }
  return [...tables].map(([block, lines]) => `[${block ? `blocks.${block}` : "values"}]\n${lines.join("\n")}\n`).join("\n");
}

/**
 * @template {keyof HTMLElementTagNameMap} Tag @param {Tag} tag @param {Partial<HTMLElementTagNameMap[Tag]>} values
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function element(tag, values = {}) {
  return Object.assign(document.createElement(tag), values);
}

/**
 * An element whose text breaks where its names have dots and underscores, units their strokes and points.
 * @template {keyof HTMLElementTagNameMap} Tag @param {Tag} tag @param {string} text
 * @param {Partial<HTMLElementTagNameMap[Tag]>} values @returns {HTMLElementTagNameMap[Tag]}
 */
export function named(tag, text, values = {}) {
  const made = element(tag, values);
  text.split(/(?<=[._/·])(?=[A-Za-z_(])/u).forEach((part, i) => made.append(...(i ? [element("wbr")] : []), part));
  return made;
}

/** A field of its own. @param {HTMLElement} place @param {string} text @param {string} id */
export function labelled(place, text, id) {
  const row = element("div", { className: "parameter" });
  const field = element("input", { id, type: "text", autocomplete: "off", spellcheck: false });
  row.append(named("label", text, { htmlFor: id }), field);
  place.append(row);
  return field;
}
