// The block diagram as a map: zoom, pan, and what the wires hold at a time.

import { element } from "./controls.mjs";
import { shown } from "./figures.mjs";

const STEP = 1.25; // of one zoom
const CLOSEST = 8;

/** @typedef {import("./figures.mjs").Scales} Scales */
/** @typedef {import("./engine.mjs").Wire} Wire */

export class Diagrams {
  /** @param {Wire[]} wires @param {Record<string, Scales>} units */
  constructor(wires, units) {
    this.wires = wires;
    this.units = units;
    for (const drawing of document.querySelectorAll("svg.proofmass")) asMap(/** @type {SVGSVGElement} */ (drawing));
  }

  /** Write below each block what its wires hold. @param {Record<string, number>} values @param {number} seconds */
  show(values, seconds) {
    for (const drawing of document.querySelectorAll("svg.proofmass")) {
      for (const old of drawing.querySelectorAll(".peek")) old.remove();
      for (const block of /** @type {NodeListOf<SVGGElement>} */ (drawing.querySelectorAll("[data-block]"))) {
        const own = this.wires.filter(({ name }) => name.startsWith(`${block.dataset.block}.`));
        own.forEach((wire, row) => {
          const text = shown(values[wire.name], this.units[wire.unit], 5);
          const port = wire.name.slice(String(block.dataset.block).length + 1);
          block.append(label(block, own.length > 1 ? `${port} ${text}` : text, row));
        });
      }
      const time = drawing.parentElement?.querySelector(".map-time");
      if (time) time.textContent = `values at ${Number(seconds.toPrecision(9))} s`;
    }
  }
}

/** A line of text below a block. @param {SVGGElement} block @param {string} text @param {number} row */
function label(block, text, row) {
  const box = /** @type {SVGRectElement} */ (block.querySelector("rect.box"));
  const made = document.createElementNS("http://www.w3.org/2000/svg", "text");
  made.setAttribute("class", "peek");
  made.setAttribute("text-anchor", "middle");
  made.setAttribute("x", String(box.x.baseVal.value + box.width.baseVal.value / 2));
  made.setAttribute("y", String(box.y.baseVal.value + box.height.baseVal.value + 13 * (row + 1)));
  made.textContent = text;
  return made;
}

/** Let a drawing be zoomed by buttons, keys and the wheel with Ctrl, and moved by dragging. @param {SVGSVGElement} drawing */
function asMap(drawing) {
  const place = drawing.parentElement;
  if (!place || place.querySelector(".map-bar")) return;
  const whole = drawing.viewBox.baseVal, { width, height } = whole;
  let zoom = 1, x = 0, y = 0;

  const settle = () => {
    x = Math.min(Math.max(0, x), width - width / zoom);
    y = Math.min(Math.max(0, y), height - height / zoom);
    drawing.setAttribute("viewBox", `${x} ${y} ${width / zoom} ${height / zoom}`);
    drawing.classList.toggle("zoomed", zoom > 1);
  };
  const zoomAt = (/** @type {number} */ factor, across = 0.5, down = 0.5) => {
    const next = Math.min(CLOSEST, Math.max(1, zoom * factor));
    x += across * (width / zoom - width / next);
    y += down * (height / zoom - height / next);
    zoom = next;
    settle();
  };
  const bar = element("div", { className: "map-bar" });
  for (const [text, title, factor] of /** @type {[string, string, number][]} */ ([["+", "Zoom in", STEP], ["−", "Zoom out", 1 / STEP], ["fit", "Show all of it", 0]])) {
    const made = element("button", { type: "button", textContent: text, title });
    made.addEventListener("click", () => zoomAt(factor));
    bar.append(made);
  }
  bar.append(element("span", { className: "map-time soft", textContent: "click a plot to see what the wires hold at that time" }));
  place.prepend(bar);
  drawing.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    const box = drawing.getBoundingClientRect();
    zoomAt(event.deltaY < 0 ? STEP : 1 / STEP, (event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
  }, { passive: false });
  drawing.addEventListener("pointermove", (event) => {
    if (zoom === 1 || !event.buttons) return;
    const scale = width / zoom / drawing.getBoundingClientRect().width;
    x -= event.movementX * scale;
    y -= event.movementY * scale;
    settle();
  });
}
