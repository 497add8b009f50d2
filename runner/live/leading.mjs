// A walk through the ticks: start where the cursor is, one tick or many, play and pause, parameters changed on the way.

import { element } from "./controls.mjs";
import { timeText } from "./figures.mjs";

const FRAMES = 250; // of a run that plays from end to end

/**
 * @typedef {{postMessage: (wish: any) => void}} Channel
 * @typedef {{tick: number, settings: any, view: any}} Start
 */

export class Leading {
  /** @param {HTMLElement} place @param {Channel} channel @param {() => Start} start @param {(tick: number) => number} timeOf
   * @param {() => void} ended */
  constructor(place, channel, start, timeOf, ended) {
    this.channel = channel;
    this.start = start;
    this.timeOf = timeOf;
    this.ended = ended;
    this.on = this.playing = this.poked = false;
    this.ticks = 1;
    this.tick = 0; // that was reached
    this.bar = element("div", { className: "buttons walk", hidden: true });
    this.step("Tick", "Go on by one tick", 1);
    this.step("10 ticks", "Go on by ten ticks", 10);
    this.step("1000 ticks", "Go on by a thousand ticks", 1000);
    this.player = element("button", { type: "button", textContent: "Play", title: "Go on until paused" });
    this.player.addEventListener("click", () => this.play());
    this.line = element("span", { className: "walk-line soft" });
    this.line.setAttribute("role", "status");
    this.bar.append(this.player, this.line);
    place.append(this.bar);
  }

  /** @param {string} text @param {string} title @param {number} ticks */
  step(text, title, ticks) {
    const made = element("button", { type: "button", textContent: text, title });
    made.addEventListener("click", () => this.channel.postMessage({ kind: "walk", act: "step", ticks }));
    this.bar.append(made);
  }

  toggle() {
    this.on = !this.on;
    this.bar.hidden = !this.on;
    this.poked = false;
    if (this.on) this.channel.postMessage({ kind: "walk", act: "begin", ...this.start() });
    else {
      this.channel.postMessage({ kind: "walk", act: "end" });
      this.ended();
    }
  }

  play() {
    const pace = Math.max(1, Math.ceil(this.ticks / FRAMES));
    this.channel.postMessage(this.playing ? { kind: "walk", act: "pause" } : { kind: "walk", act: "play", pace });
  }

  /** Other parameters from this tick on. @param {Record<string, number>} values */
  poke(values) {
    this.poked = true;
    const pace = Math.max(1, Math.ceil(this.ticks / FRAMES));
    this.channel.postMessage({ kind: "walk", act: this.playing ? "play" : "poke", pace, values });
  }

  /** @param {any} message */
  hear(message) {
    this.playing = message.playing;
    this.ticks = message.ticks;
    this.tick = message.tick;
    this.player.textContent = message.playing ? "Pause" : "Play";
    const end = message.sound ? "" : "; a number is not finite, or does not fit its format";
    const poked = this.poked ? "; parameters were changed on the way, so these are not the bits of one run" : "";
    const done = message.tick === message.ticks ? ", the last" : "";
    const at = timeText(this.timeOf(Math.max(0, message.tick - 1)));
    this.line.textContent = `tick ${message.tick.toLocaleString("en")}${done} at ${at}${poked}${end}`;
  }
}
