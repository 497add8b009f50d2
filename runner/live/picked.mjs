// The block that was clicked: what it is, its equation, and scopes of its ports beside its controls.

import { Charts } from "./charts.mjs";
import { element, named } from "./controls.mjs";

/**
 * @typedef {import("./engine.mjs").Wire} Wire
 * @typedef {{kind: string, inputs: Record<string, string>, outputs: string[]}} Block
 * @typedef {{doc: string, equation: string}} Kind
 */

const LOW = 92; // pixels of a scope

export class Picked {
  /** @param {HTMLElement} above  the controls @param {HTMLElement} below  them @param {() => void} closed */
  constructor(above, below, closed) {
    this.path = "";
    this.head = element("div", { className: "picked", hidden: true });
    this.more = element("div", { className: "picked", hidden: true });
    this.scopes = element("div", { className: "scopes" });
    this.closed = closed;
    above.append(this.head);
    below.append(this.more);
    /** @type {Charts | null} */
    this.charts = null;
    /** @type {string[]} */
    this.signals = []; // of the scopes
  }

  /** @param {string} path  empty for none @param {import("./view.mjs").Model} model
   * @param {(range: [number, number] | null) => void} zoomed @param {(seconds: number) => void} looked */
  open(path, model, zoomed, looked) {
    this.path = path;
    this.charts?.remove();
    this.charts = null;
    this.signals = [];
    this.head.hidden = this.more.hidden = !path;
    if (!path) return;
    const block = model.blocks[path], kind = block && model.kinds[block.kind];
    const close = element("button", { type: "button", textContent: "×", className: "close" });
    close.title = "Close the block (Escape)";
    close.addEventListener("click", this.closed);
    const title = named("strong", path, { className: "title" }), about = element("p", { className: "soft" });
    about.textContent = kind ? `${block.kind}. ${kind.doc.split("\n\n")[0]}` : "The blocks inside this subgraph.";
    this.head.replaceChildren(close, title, about);
    this.more.replaceChildren(this.scopes, ...(kind?.equation ? [equationOf(kind.equation)] : []));
    if (block) this.scope(block, model, zoomed, looked);
  }

  /** @param {Block} block @param {import("./view.mjs").Model} model
   * @param {(range: [number, number] | null) => void} zoomed @param {(seconds: number) => void} looked */
  scope(block, model, zoomed, looked) {
    const wires = new Map(model.loop.wires.map((wire) => [wire.name, wire]));
    const known = new Map(Object.entries(block.inputs).map(([port, signal]) => [signal, `into ${port}`]));
    for (const signal of block.outputs) known.set(signal, known.get(signal) ?? "");
    for (const signal of [...known.keys()]) if (!wires.has(signal)) known.delete(signal);
    this.signals = [...known.keys()];
    const probes = [...known].map(([signal, about]) => {
      const { unit, doc, held } = /** @type {Wire} */ (wires.get(signal));
      return { signal, unit, doc: about || doc, stride: 1, phase: 0, type: "float64", bytes: 8, held, shape: [], fraction: null };
    });
    this.charts = new Charts(this.scopes, probes, model.units, zoomed, looked, LOW);
    this.charts.charts.forEach((chart) => (chart.recorded = true));
  }
}

/** The equation of a block as the documents set it; its HTML is only ever parsed, and has no scripts.
 * @param {string} html  paragraphs */
function equationOf(html) {
  const made = element("div", { className: "equation" });
  made.append(...new DOMParser().parseFromString(html, "text/html").body.children);
  return made;
}
