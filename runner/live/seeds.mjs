// Many seeds: histograms of the measures.

import { element } from "./controls.mjs";
import { showHistograms } from "./histograms.mjs";

export const SEEDS = 300; // of a histogram

export class Seeds {
  /** @param {import("./view.mjs").View} view */
  constructor(view) {
    this.view = view;
    this.on = false;
    this.place = element("div", { className: "histograms", hidden: true });
  }

  /** @param {boolean} on */
  show(on) {
    this.on = on;
    this.place.hidden = !on;
    this.place.replaceChildren();
    this.view.many.setAttribute("aria-pressed", String(on));
    this.ask();
  }

  ask() {
    this.view.channel.postMessage({ kind: "seeds", count: this.on ? SEEDS : 0, settings: this.view.settings() });
  }

  /** @param {any} message */
  hear(message) {
    const { model, state: { seed } } = this.view, last = BigInt(seed) + BigInt(Math.max(0, message.done - 1));
    const scales = (/** @type {string} */ name) => {
      const probe = model?.loop.probes.find(({ signal }) => name.endsWith(` ${signal}`));
      const of = model?.loop.measures.find((one) => one.name === name) ?? probe;
      return model?.units[of?.unit ?? "1"] ?? [{ exponent: 0, text: "" }];
    };
    const about = `${message.done} of ${message.count} runs, of the seeds ${seed} to ${last}`;
    if (this.on) showHistograms(this.place, message.values, scales, about);
  }
}
