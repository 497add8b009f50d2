// The fields of a run: how long it is, and its seed.

import { element, labelled } from "./controls.mjs";

export class Fields {
  /** @param {HTMLElement} place @param {import("./view.mjs").View} view */
  constructor(place, view) {
    this.view = view;
    const fields = element("div", { className: "fields" });
    this.duration = labelled(fields, "duration", "run-duration");
    this.seed = labelled(fields, "seed", "run-seed");
    place.append(fields);
    this.duration.addEventListener("change", () => {
      const wrong = view.ticksIn(this.duration.value) === null ? 'a time, such as "50 ms" or "0.5"' : "";
      this.take(this.duration, wrong, () => {
        view.zoom = null;
        view.change({ ...view.state, duration: this.duration.value.trim() });
      });
    });
    this.seed.addEventListener("change", () => {
      const wrong = /^\d{1,18}$/.test(this.seed.value.trim()) ? "" : "a whole number, such as 7";
      this.take(this.seed, wrong, () => view.change({ ...view.state, seed: this.seed.value.trim() }));
    });
  }

  /** @param {HTMLInputElement} field @param {string} wrong  why it is refused; empty if it is right
   * @param {() => void} taken */
  take(field, wrong, taken) {
    field.setCustomValidity(wrong);
    if (wrong) field.reportValidity();
    else taken();
  }

  /** @param {import("./view.mjs").State} state */
  show({ duration, seed }) {
    this.duration.value = duration;
    this.seed.value = seed;
  }
}
