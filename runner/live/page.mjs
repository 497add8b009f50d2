// Where the page begins: in a window it shows the graph that it carries, in a worker it runs the loop.

import { Served } from "./served.mjs";
import { View } from "./view.mjs";
import { makeWorker } from "./worker.mjs";

/** A worker made of this very script; the page itself where there is none. */
function makeChannel() {
  const script = document.getElementById("live-script")?.textContent ?? "";
  try {
    const worker = new Worker(URL.createObjectURL(new Blob([script], { type: "text/javascript" })));
    return {
      postMessage: (/** @type {any} */ wish) => worker.postMessage(wish),
      listen: (/** @type {(message: any) => void} */ hear) => worker.addEventListener("message", ({ data }) => hear(data)),
    };
  } catch {
    /** @type {(message: any) => void} */
    let hear = () => {};
    const work = makeWorker((message) => setTimeout(() => hear(message)));
    return {
      postMessage: (/** @type {any} */ wish) => void work(wish),
      listen: (/** @type {(message: any) => void} */ listener) => (hear = listener),
    };
  }
}

export function begin() {
  if (typeof document === "undefined") {
    const work = makeWorker((message) => postMessage(message));
    let before = Promise.resolve();
    addEventListener("message", ({ data }) => {
      if (data.kind === "open") before = work(data);
      else void before.then(() => work(data));
    });
    return;
  }
  const place = document.getElementById("live"), carried = document.getElementById("live-model");
  if (place?.dataset.served !== undefined) void new Served(place, makeChannel).begin();
  else if (place && carried?.textContent) new View(place, makeChannel).open(JSON.parse(carried.textContent));
}

if (typeof document === "undefined" || document.readyState !== "loading") begin();
else addEventListener("DOMContentLoaded", begin);
