// Hands on plots and maps: fingers that drag a stretch of time, two that pinch, keys that move and zoom.

const MOVE = 0.2; // of what is seen, by one key
const LEAST = 10; // pixels that a finger drags

/** Let a finger drag a stretch, as a mouse does. @param {any} plot @param {() => void} ended */
export function dragged(plot, ended) {
  const over = /** @type {HTMLElement} */ (plot.over);
  let start = NaN;
  const across = (/** @type {PointerEvent} */ event) => {
    const box = over.getBoundingClientRect();
    return Math.min(box.width, Math.max(0, event.clientX - box.left));
  };
  over.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch" && event.isPrimary) start = across(event);
  });
  over.addEventListener("pointermove", (event) => {
    if (event.pointerType !== "touch" || Number.isNaN(start)) return;
    const now = across(event), width = Math.abs(now - start);
    if (width >= LEAST) plot.setSelect({ left: Math.min(start, now), width, top: 0, height: over.clientHeight }, false);
  });
  over.addEventListener("pointerup", (event) => {
    if (event.pointerType !== "touch" || Number.isNaN(start)) return;
    if (Math.abs(across(event) - start) >= LEAST) ended();
    start = NaN;
  });
  over.addEventListener("pointercancel", () => {
    start = NaN;
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  });
}

/** The range that a key asks for: null for all, undefined for another key. @param {KeyboardEvent} event
 * @param {[number, number]} range @param {number} about  what stays in its place
 * @returns {[number, number] | null | undefined} */
export function moved(event, range, about) {
  const [first, last] = range, step = MOVE * (last - first);
  /** @param {number} by @returns {[number, number]} */
  const scaled = (by) => [about + (first - about) * by, about + (last - about) * by];
  if (event.ctrlKey || event.metaKey || event.altKey) return undefined;
  if (event.key === "ArrowLeft") return first - step < 0 ? [0, last - first] : [first - step, last - step];
  if (event.key === "ArrowRight") return [first + step, last + step];
  if (event.key === "+" || event.key === "=") return scaled(1 / (1 + MOVE));
  if (event.key === "-") return scaled(1 + MOVE);
  return event.key === "0" || event.key === "Home" ? null : undefined;
}

/** Hear of two fingers that pinch: a factor, and where, in parts of the place. @param {SVGSVGElement} place
 * @param {(factor: number, across: number, down: number) => void} zoom */
export function pinched(place, zoom) {
  /** @type {Map<number, PointerEvent>} */
  const fingers = new Map();
  const apart = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  };
  place.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch") fingers.set(event.pointerId, event);
  });
  place.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = fingers.size === 2 ? apart() : 0;
    fingers.set(event.pointerId, event);
    if (!before) return;
    const [a, b] = [...fingers.values()], box = place.getBoundingClientRect();
    const x = (a.clientX + b.clientX) / 2, y = (a.clientY + b.clientY) / 2;
    zoom(apart() / before, (x - box.left) / box.width, (y - box.top) / box.height);
  });
  for (const end of ["pointerup", "pointercancel", "pointerleave"])
    place.addEventListener(end, (event) => fingers.delete(/** @type {PointerEvent} */ (event).pointerId));
}
