// The strip of verdicts: a chip for each loop, each of its limits and each requirement, always in sight.

import { element } from "./controls.mjs";
import { shown } from "./figures.mjs";

/**
 * @typedef {import("./figures.mjs").Scales} Scales
 * @typedef {{id: string, met: boolean | null, value: string, why: string}} Verdict  null: there is no answer
 * @typedef {{id: string, text: string, measure: string, at_least: number | null, at_most: number | null}} Required
 */

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
    this.asking = this.again = false; // whether the process is asked, and shall be again
  }

  /** Requirements of measures against a run. @param {Required[]} required @param {Record<string, number>} values
   * @param {(measure: string) => Scales} scales */
  measure(required, values, scales) {
    this.measured = required.map(({ id, text, measure, at_least, at_most }) => {
      const value = values[measure], known = Number.isFinite(value), of = scales(measure);
      const above = at_most !== null && value > at_most, most = above || at_least === null;
      const missed = above || (at_least !== null && value < at_least), limit = most ? at_most : at_least;
      const sign = missed ? (most ? ">" : "<") : most ? "≤" : "≥";
      const about = known ? `${shown(value, of, 5)} ${sign} ${shown(limit ?? NaN, of, 5)}` : "no value";
      return { id, met: known ? !missed : null, value: about, why: text };
    });
    this.show();
  }

  /** @param {Verdict[]} verdicts */
  judge(verdicts) {
    this.judged = verdicts;
    this.show();
  }

  /** Ask for verdicts; while that goes on the newest question waits.
   * @param {(state: any) => Promise<Verdict[] | null>} judge @param {() => any} state */
  async ask(judge, state) {
    this.bar.classList.add("waiting"); // they are those of other values
    this.again = this.asking;
    if (this.asking) return;
    this.asking = true;
    do {
      this.again = false;
      const verdicts = await judge(state()).catch(() => null);
      if (verdicts) this.judge(verdicts);
    } while (this.again);
    this.asking = false;
    this.bar.classList.remove("waiting");
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
  write(chip, { id, met, value, why }) {
    chip.dataset.met = String(met);
    chip.dataset.of = id;
    chip.title = `${id}: ${WORDS[/** @type {"true"} */ (String(met))]}, ${value}${why ? `. ${why}` : ""}`;
    chip.setAttribute("aria-label", chip.title);
    chip.children[0].textContent = id;
    chip.children[1].textContent = value;
  }
}
