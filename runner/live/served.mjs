// A page that a process serves: it hears of every save, shows what is wrong with the file, and keeps windows in step.

import { element } from "./controls.mjs";
import { drawn } from "./diagrams.mjs";
import { showHistograms } from "./histograms.mjs";
import { hearLong } from "./long.mjs";
import { View } from "./view.mjs";

const AGAIN = 1000; // milliseconds from one try to the next
const OFTEN = 50; // milliseconds between what other windows are told
const SILENCE = 6000; // milliseconds without a sign of life
const KEPT_ALIVE = 6e4; // bytes, of which browsers allow 64 KiB
const STILL = 300; // milliseconds without a change, after which a tab is computed anew

/**
 * @typedef {{file: string, line: number, key: string, message: string, got: string, expected: string, hint: string}} Problem
 * @typedef {import("./view.mjs").State} State
 */

export class Served {
  /** @param {HTMLElement} place @param {() => any} makeChannel */
  constructor(place, makeChannel) {
    const body = /** @type {HTMLElement} */ (place.parentElement);
    this.token = location.hash.slice(1);
    this.proved = false; // whether the other side has shown that it has the token
    this.window = crypto.randomUUID();
    this.lost = element("p", { className: "warning lost", hidden: true });
    this.lost.setAttribute("role", "alert");
    this.wrong = element("div", { className: "problems", hidden: true });
    this.wrong.setAttribute("role", "alert");
    body.insertBefore(this.lost, place);
    body.insertBefore(this.wrong, place);
    /** @type {Record<string, string>} */
    this.changes = {}; // of what the loop does not take anew
    /** @type {any} */
    this.study = null; // as it stands
    /** @type {import("./view.mjs").Process} */
    const process = {
      ask: (name, text) => this.change(name, text),
      draw: (paths) => this.draw(paths),
      long: (wish) => void this.send("/long", wish).catch(() => {}),
      judge: (state, thorough) => this.judge(state, thorough),
    };
    this.view = new View(place, makeChannel, (state) => this.changed(state), process);
    this.bar = element("div", { className: "buttons tabs" });
    this.bar.setAttribute("role", "tablist");
    this.panel = element("div", { className: "panel", hidden: true });
    this.view.top.prepend(this.bar);
    this.view.main.append(this.panel);
    this.saver = this.view.button("Save", "Write the sliders into the file (Ctrl+S)", () => void this.save());
    this.undoer = this.view.button("Undo save", "Take back what was saved last", () => void this.undo());
    this.saver.hidden = this.undoer.hidden = true;
    document.addEventListener("keydown", (event) => {
      if (event.key !== "s" || !(event.ctrlKey || event.metaKey) || this.saver.hidden) return;
      event.preventDefault();
      if (document.activeElement instanceof HTMLElement) document.activeElement.blur(); // takes what is typed there
      void this.save();
    });
    this.tab = "";
    this.asked = 0; // number of the newest question
    /** @type {State | null} */
    this.untold = null; // of the other windows
    this.telling = false;
  }

  async begin() {
    if (!this.token) {
      this.say("Open the address that proofmass live shows in the terminal: it ends in a token.");
      return;
    }
    for (;;) {
      try {
        await this.listen();
      } catch {
        this.say("The process has ended: start proofmass live again, and open the address that it shows.");
      }
      this.proved = false;
      await new Promise((resume) => setTimeout(resume, AGAIN));
    }
  }

  /** Ask for a proof of the token, which goes to nobody who does not have it: another process may listen by now. */
  async prove() {
    const nonce = crypto.randomUUID();
    const answer = await fetch("/proof", { headers: { "X-Proofmass-Nonce": nonce } });
    const text = new TextEncoder();
    const kind = { name: "HMAC", hash: "SHA-256" };
    const key = await crypto.subtle.importKey("raw", text.encode(this.token), kind, false, ["sign"]);
    const proof = new Uint8Array(await crypto.subtle.sign("HMAC", key, text.encode(nonce)));
    const wanted = Array.from(proof, (byte) => byte.toString(16).padStart(2, "0")).join("");
    this.proved = answer.ok && (await answer.text()) === wanted;
    return this.proved;
  }

  async listen() {
    if (!(await this.prove())) {
      this.say("This address is no longer valid: open the one that proofmass live shows in the terminal.");
      return;
    }
    const answer = await fetch("/events", { headers: { "X-Proofmass-Token": this.token } });
    if (!answer.ok || !answer.body) {
      this.say("This address is no longer valid: open the one that proofmass live shows in the terminal.");
      return;
    }
    const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
    this.say("");
    for (let text = ""; ; ) {
      const { value, done } = await Promise.race([reader.read(), silence()]);
      if (done) throw new Error("closed");
      text += value;
      const events = text.split("\n\n");
      text = events.pop() ?? "";
      for (const event of events) this.hear(JSON.parse(event.replace(/^data: /, "")));
    }
  }

  /** @param {any} message */
  hear(message) {
    if (message.kind === "graph") this.show(message);
    else if (message.kind === "problems") this.complain(message.problems);
    else if (message.kind === "long") hearLong(this.view, message);
    else if (message.kind === "diagram") {
      this.view.map.replaceChildren(drawn(message.svg));
      this.view.lookAtDiagrams();
    } else if (message.kind === "study") this.showStudy(message);
    else if (message.kind === "state" && message.window !== this.window) this.follow(message.state);
  }

  /** @param {any} message */
  show(message) {
    this.complain([]);
    document.title = message.model.name;
    const head = document.querySelector("h1");
    if (head) head.textContent = message.model.name;
    this.changes = message.changes;
    this.saver.hidden = this.undoer.hidden = message.undo === null;
    this.undoer.disabled = !message.undo;
    this.view.open(message.model);
    this.bar.replaceChildren(...["", ...message.tabs].map((name) => this.tabButton(name)));
    this.showTab(message.tabs.includes(this.tab) ? this.tab : "");
  }

  /** @param {State} state */
  follow(state) {
    this.view.follow(state);
    this.later();
  }

  /** What is wrong with the file; the last good picture stays. @param {Problem[]} problems @param {string} about */
  complain(problems, about = "Below is the graph as it was when it was last right.") {
    this.wrong.hidden = !problems.length;
    this.wrong.replaceChildren(...problems.map(problemOf));
    if (problems.length) this.wrong.append(element("p", { className: "soft", textContent: about }));
    this.view.place.classList.toggle("stale", problems.length > 0);
  }

  /** @param {string} text */
  say(text) {
    this.lost.hidden = !text;
    this.lost.textContent = text;
  }

  /** @param {string} name */
  tabButton(name) {
    const made = element("button", { type: "button", textContent: name || "run" });
    made.dataset.tab = name;
    made.setAttribute("role", "tab");
    made.addEventListener("click", () => this.showTab(name));
    return made;
  }

  /** @param {string} name */
  showTab(name) {
    this.tab = name;
    for (const one of this.bar.children) one.setAttribute("aria-selected", String(/** @type {HTMLElement} */ (one).dataset.tab === name));
    for (const part of [this.view.plots, this.view.table]) part.hidden = name !== "";
    this.view.seeds.place.hidden = name !== "" || !this.view.seeds.on;
    if (name) this.view.place.dataset.tab = name;
    else delete this.view.place.dataset.tab;
    this.panel.hidden = name === "";
    this.panel.replaceChildren(element("p", { className: "soft", textContent: "computing" }));
    if (name === "study") this.showStudy(this.study);
    else if (name) void this.ask();
  }

  /** Runs of a study that the process does meanwhile. @param {any} message */
  showStudy(message) {
    this.study = message;
    if (this.tab !== "study" || !message) return;
    this.panel.classList.remove("stale");
    if (message.problems) return this.panel.replaceChildren(...message.problems.map(problemOf));
    const scales = (/** @type {string} */ name) => message.units[name] ?? [{ exponent: 0, text: "" }];
    const state = message.done < message.runs ? "running" : "finished";
    showHistograms(this.panel, message.values, scales, `${message.name}: ${message.done} of ${message.runs} runs, ${state}`, message.limits);
  }

  /** A parameter that the process puts into the graph. @param {string} name @param {string} text */
  change(name, text) {
    this.changes = { ...this.changes, [name]: text };
    void this.send("/change", { changes: this.changes }).catch(() => {});
  }

  /** @param {State} state @param {boolean} thorough */
  async judge(state, thorough) {
    const answer = await this.send("/verdicts", { state, thorough });
    if (!answer.ok) return null;
    const { verdicts, more = false, problems = [] } = await answer.json();
    const why = (/** @type {Problem} */ { key, message: value }) => ({ id: key || "loops", met: null, value, why: "" });
    return { verdicts: verdicts ?? problems.map(why), more };
  }

  /** Write what the sliders say into the file. */
  async save() {
    const values = Object.keys(this.view.state.values);
    if (!values.length && !Object.keys(this.changes).length) return this.view.say("nothing is changed");
    await this.written("/save", `saved: ${values.join(", ")}`);
  }

  undo() {
    return this.written("/undo", "the last save is undone");
  }

  /** @param {string} path @param {string} done */
  async written(path, done) {
    try {
      const answer = await this.post(path, this.view.state);
      const refused = { problems: [{ message: "The process does not write this." }] };
      const { problems } = answer.ok ? await answer.json() : refused;
      if (problems) this.complain(problems, "Nothing was written.");
      else this.view.note = `${done}; `;
    } catch {
      // the process is gone: the page says so
    }
  }

  /** The diagram with subgraphs unfolded. @param {string[]} paths */
  async draw(paths) {
    const answer = await this.send("/diagram", { unfolded: paths });
    return answer.ok ? (await answer.json()).svg : "";
  }

  /** Tell the other windows, one state after the other: what is told at once may come in another order.
   * @param {State} state */
  changed(state) {
    this.untold = state;
    if (!this.telling) void this.tell();
    this.later();
  }

  async tell() {
    this.telling = true;
    for (; this.untold; await new Promise((resume) => setTimeout(resume, OFTEN))) {
      const state = this.untold;
      this.untold = null;
      await this.post("/state", state).catch(() => {});
    }
    this.telling = false;
  }

  later() {
    clearTimeout(this.asking);
    if (this.tab && this.tab !== "study") this.asking = setTimeout(() => void this.ask(), STILL);
  }

  /** What the process computes for the tab. */
  async ask() {
    const number = ++this.asked;
    this.panel.classList.add("stale");
    try {
      const answer = await this.post(`/${this.tab}`, this.view.state);
      if (number !== this.asked) return;
      const found = answer.ok ? await answer.json() : { text: "The process has no answer for these values.", pictures: [] };
      const parts = found.problems ? found.problems.map(problemOf) : [...found.pictures.map(drawn), element("pre", { textContent: found.text })];
      this.panel.replaceChildren(...parts);
      this.panel.classList.remove("stale");
    } catch {
      // the process is gone: the page says so, and asks again when it is back
    }
  }

  /** @param {string} path @param {State} state */
  post(path, state) {
    return this.send(path, { state });
  }

  /** @param {string} path @param {object} data */
  send(path, data) {
    if (!this.proved) return Promise.reject(new Error("unproved"));
    const headers = { "X-Proofmass-Token": this.token, "Content-Type": "application/json" };
    const body = JSON.stringify({ ...data, window: this.window });
    const keepalive = path === "/state" && body.length < KEPT_ALIVE; // so that a window that closes is still heard
    return fetch(path, { method: "POST", keepalive, headers, body });
  }
}

/** @returns {Promise<never>} */
function silence() {
  return new Promise((_, fail) => setTimeout(() => fail(new Error("silent")), SILENCE));
}

/** @param {Problem} problem */
function problemOf(problem) {
  const made = element("div", { className: "problem" });
  const place = [problem.file, problem.line || "", problem.key].filter(Boolean).join(":");
  made.append(element("strong", { textContent: place }), ` ${problem.message}`);
  const rows = [["got", problem.got], ["expected", problem.expected], ["hint", problem.hint]].filter(([, text]) => text);
  for (const [name, text] of rows) made.append(element("div", { textContent: `${name}: ${text}` }));
  return made;
}
