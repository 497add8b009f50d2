// What a page says of its changes: lines of a graph file, and the command that computes the same bits.

import { asOptions, asToml } from "./controls.mjs";

/** @typedef {import("./view.mjs").View} View */

/** @param {View} view */
export function toml({ model, state }) {
  return model ? asToml(state.values, model.sliders) : "";
}

/** @param {View} view */
export function command(view) {
  const { file, options } = /** @type {import("./view.mjs").Model} */ (view.model), { values, seed } = view.state;
  const said = [`--samples ${view.ticks()}`, `--seed ${seed}`, ...asOptions(values)];
  return ["proofmass run", file, ...said, ...(Object.keys(values).length ? options : [])].join(" ");
}

/** @param {View} view @param {string} text */
export async function copy(view, text) {
  if (!text) return view.say("nothing is changed");
  try {
    await navigator.clipboard.writeText(text);
    view.say("copied");
  } catch {
    view.say(text); // where the browser gives no clipboard, to be copied by hand
  }
}

/** How many ticks a run had, and how long they took. @param {{ticks: number, wanted: number, fault: string, milliseconds: number}} run */
export function ticksIn({ ticks, wanted, fault, milliseconds }) {
  const short = ticks < wanted && !fault ? "; the memory of a page holds no more" : "";
  return `${ticks.toLocaleString("en")} ticks in ${Number(milliseconds.toPrecision(3))} ms${short}`;
}

