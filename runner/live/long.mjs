// Runs that are too long for a page, which the process does: the page draws the lowest and highest rows of each pixel.

/** @typedef {import("./view.mjs").View} View */

export const TOO_LONG = 2e7; // ticks that a page runs itself where there is a process

/** @param {View} view @param {(wish: any) => void} ask */
export function askForLong(view, ask) {
  view.bits.textContent = "";
  view.say("the process begins this long run");
  ask({ state: view.state, ticks: view.ticks(), pixels: view.charts?.pixels ?? 600 });
}

/** Show a run of the process, as far as it is. @param {View} view @param {any} message */
export function hearLong(view, message) {
  const of = (/** @type {any} */ state) => JSON.stringify([Object.entries(state.values).sort(), state.seed, state.duration]);
  if (of(message.state) !== of(view.state)) return;
  if (message.problems) return view.say(message.problems.map((/** @type {any} */ one) => one.message).join("; "), true);
  const pictures = message.pictures.map((/** @type {any} */ one) => ({ ...one, x: Float64Array.from(one.x), y: Float64Array.from(one.y), frozen: null, frozenX: null }));
  view.draw(pictures);
  const part = `${message.done.toLocaleString("en")} of ${message.ticks.toLocaleString("en")} ticks by the process`;
  if (!message.measures) return view.say(`running: ${part}`);
  view.measures = message.measures;
  view.showMeasures();
  if (message.sound) view.say(`${part} in ${Number(message.seconds.toPrecision(3))} s`);
  else view.say(`stopped: a number is not finite, or does not fit its format (${part})`, true);
}
