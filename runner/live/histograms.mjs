// Histograms of measures: of many seeds that the page runs, or of the runs of a study in the process.

import { element } from "./controls.mjs";
import { shown } from "./figures.mjs";

/** @typedef {import("./figures.mjs").Scales} Scales */

const ACROSS = 300, TALL = 120, BASE = 16; // pixels

/** @param {HTMLElement} place @param {Record<string, number[]>} values  by measure
 * @param {(name: string) => Scales} scalesOf @param {string} about @param {Record<string, [number | null, number | null]>} limits */
export function showHistograms(place, values, scalesOf, about, limits = {}) {
  const figures = Object.entries(values).map(([name, all]) => histogram(name, all.filter(Number.isFinite), scalesOf(name), limits[name]));
  place.replaceChildren(element("p", { className: "soft", textContent: about }), ...figures);
}

/** @param {string} name @param {number[]} values @param {Scales} scales @param {[number | null, number | null]} [limits] */
function histogram(name, values, scales, limits = [null, null]) {
  const figure = element("figure", { className: "histogram" });
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const spread = Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / Math.max(1, values.length - 1));
  const text = values.length ? `mean ${shown(mean, scales, 5)}, standard deviation ${shown(spread, scales, 3)}` : "no values: not done yet, or the run ends before this measure begins";
  figure.append(element("figcaption", { textContent: name }), picture(values, `${name}: ${text}`, limits, scales));
  figure.append(element("p", { className: "soft", textContent: text }));
  return figure;
}

/** @param {number[]} values @param {string} about @param {[number | null, number | null]} limits @param {Scales} scales */
function picture(values, about, limits, scales) {
  const svg = shape("svg", { viewBox: `0 0 ${ACROSS} ${TALL}`, width: ACROSS, height: TALL, role: "img", "aria-label": about });
  if (!values.length) return svg;
  const low = Math.min(...values), high = Math.max(...values), wide = high - low || Math.abs(low) || 1;
  const count = Math.max(5, Math.min(40, Math.ceil(Math.sqrt(values.length))));
  const bins = new Array(count).fill(0);
  for (const value of values) bins[Math.min(count - 1, Math.floor(((value - low) / wide) * count))] += 1;
  const most = Math.max(...bins), step = ACROSS / count;
  bins.forEach((bin, i) => {
    const tall = (bin / most) * (TALL - BASE);
    svg.append(shape("rect", { class: "bin", x: i * step + 0.5, y: TALL - BASE - tall, width: step - 1, height: tall }));
  });
  svg.append(shape("path", { class: "base", d: `M0 ${TALL - BASE}H${ACROSS}` }));
  const digits = Math.min(12, Math.max(3, Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(high)) / wide)) + 3));
  for (const [x, value, anchor] of /** @type {[number, number, string][]} */ ([[0, low, "start"], [ACROSS, high, "end"]])) {
    const label = shape("text", { x, y: TALL - 3, "text-anchor": anchor, class: "end" });
    label.textContent = shown(value, scales, digits);
    svg.append(label);
  }
  for (const limit of limits)
    if (limit !== null && limit >= low && limit <= low + wide) svg.append(shape("path", { class: "limit", d: `M${((limit - low) / wide) * ACROSS} 0V${TALL - BASE}` }));
  return svg;
}

/** @param {string} name @param {Record<string, string | number>} values */
function shape(name, values) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(values)) made.setAttribute(key, String(value));
  return made;
}
