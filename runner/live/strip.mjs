// The strip of verdicts: a chip for each loop, each of its limits and each requirement, always in sight.

import { element } from "./controls.mjs";
import { shown } from "./figures.mjs";

/**
 * @typedef {import("./figures.mjs").Scales} Scales
 * @typedef {{id: string, met: boolean | null, value: string, why: string, asked?: boolean}} Verdict
 *   of which `met` is null where there is no answer, or none is asked for
 * @typedef {{verdicts: Verdict[], more: boolean}} Answer  of which there is more if it is asked for in full
 * @typedef {{id: string, text: string, measure: string, at_least: number | null, at_most: number | null}} Required
 */

const AT_REST = 300; // milliseconds without a change, after which a full answer is asked for
const NO_PROCESS = "A report computes no margins: proofmass margins and proofmass live do.";
const WORDS = { true: "kept", false: "missed", null: "no answer" };

export class Strip {
  /** @param {HTMLElement} place @param {((text: string) => void) | null} told  hears of a chip that is clicked */
  constructor(place, told = null) {
    this.told = told;
    this.bar = element("div", { className: "strip", hidden: true });
    this.bar.setAttribute("role", "group");
    this.bar.setAttribute("aria-label", "verdicts");
    place.append(this.bar);
    /** @type {Verdict[]} */
    this.judged = []; // by the process
    /** @type {Verdict[]} */
    this.measured = []; // by the run of the page
    this.asking = false;
    this.number = 0; // of the newest question
  }

  /** Requirements of measures against a run. @param {Required[]} required @param {Record<string, number>} values
   * @param {Map<string, Scales>} scales  by measure */
  measure(required, values, scales) {
    this.measured = required.map(({ id, text, measure, at_least, at_most }) => {
      const value = values[measure], known = Number.isFinite(value);
      const of = scales.get(measure) ?? [{ exponent: 0, text: "" }];
      const above = at_most !== null && value > at_most, most = above || at_least === null;
      const missed = above || (at_least !== null && value < at_least), limit = most ? at_most : at_least;
      const sign = missed ? (most ? ">" : "<") : most ? "≤" : "≥";
      const about = known ? `${shown(value, of, 5)} ${sign} ${shown(limit ?? NaN, of, 5)}` : "no value";
      return { id, met: known ? !missed : null, value: about, why: text };
    });
    this.show();
  }

  /** Show the loops, and ask for their verdicts where there is a process.
   * @param {string[]} loops @param {((thorough: boolean) => Promise<Answer | null>) | null} judge */
  look(loops, judge) {
    if (judge) this.expect(loops, "computing", "");
    else this.expect(loops, "not asked here", NO_PROCESS);
    if (judge) void this.ask(judge);
  }

  /** Name the loops before anything is known of them.
   * @param {string[]} loops @param {string} value @param {string} why */
  expect(loops, value, why) {
    const known = new Set(this.judged.map(({ id }) => id));
    const unknown = loops.map((id) => ({ id, met: null, value, why, asked: false }));
    if (loops.some((id) => !known.has(id))) this.judged = unknown;
    this.show();
  }

  /** Ask for verdicts: at once, while that goes on the newest question waits; in full when nothing has moved.
   * @param {(thorough: boolean) => Promise<Answer | null>} judge */
  async ask(judge) {
    const number = ++this.number;
    clearTimeout(this.still);
    this.bar.classList.add("waiting"); // they are those of other values
    if (this.asking) return;
    this.asking = true;
    const answer = await judge(false).catch(() => null);
    this.asking = false;
    if (answer) this.judge(answer);
    if (number !== this.number) return void this.ask(judge);
    if (!answer?.more) return void this.bar.classList.remove("waiting");
    this.still = setTimeout(async () => {
      const whole = await judge(true).catch(() => null);
      if (number !== this.number) return;
      this.bar.classList.remove("waiting");
      if (whole) this.judge(whole);
    }, AT_REST);
  }

  /** Take verdicts; what only a full answer has stays as it was until then.
   * @param {Answer} answer */
  judge({ verdicts, more }) {
    const ids = new Set(verdicts.map(({ id }) => id));
    this.judged = more ? [...verdicts, ...this.judged.filter(({ id }) => !ids.has(id))] : verdicts;
    this.show();
  }

  show() {
    const all = [...this.judged, ...this.measured];
    this.bar.hidden = !all.length;
    while (this.bar.children.length > all.length) this.bar.lastElementChild?.remove();
    all.forEach((verdict, i) => this.write(/** @type {HTMLElement} */ (this.bar.children[i] ?? this.chip()), verdict));
  }

  chip() {
    const made = element("button", { type: "button", className: "chip" });
    made.append(element("strong"), element("span"));
    made.addEventListener("click", () => this.told?.(made.title));
    this.bar.append(made);
    return made;
  }

  /** @param {HTMLElement} chip @param {Verdict} verdict */
  write(chip, { id, met, value, why, asked = true }) {
    const title = `${id}: ${WORDS[/** @type {"true"} */ (String(met))]}, ${value}${why ? `. ${why}` : ""}`;
    const said = JSON.stringify([title, asked]);
    if (chip.dataset.said === said) return; // each frame of a drag asks
    Object.assign(chip.dataset, { said, asked: String(asked), met: String(met), of: id });
    chip.title = title;
    chip.setAttribute("aria-label", title);
    chip.children[0].textContent = id;
    chip.children[1].textContent = value;
  }
}
