// Wires of a drawn diagram: whose signals they carry, where they begin, and what stands there.

/** Signals of the wire, the tab or the bundle at a place. @param {Element} place */
export function signalsOf(place) {
  const wire = /** @type {SVGGElement | null} */ (place.closest("[data-signal], [data-net], [data-signals]"));
  const { signal, net, signals } = wire?.dataset ?? {};
  return signals?.split(" ") ?? [signal ?? net ?? []].flat();
}

/** Where a wire begins, whether it goes right or left, and how far. @param {SVGGElement} wire */
export function startOf(wire) {
  const path = wire.querySelector(".reach")?.getAttribute("d") ?? "";
  const [x, y, next] = (path.match(/-?[\d.]+/g) ?? []).map(Number);
  return Number.isFinite(next) ? { x, y, way: next < x ? -1 : 1, reach: Math.abs(next - x) } : null;
}

/** How far flags of probes and tabs of nets reach, by the starts of their wires. @param {SVGSVGElement} drawing */
export function flagsOf(drawing) {
  /** @type {Map<string, number>} */
  const flags = new Map();
  for (const flag of drawing.querySelectorAll("[data-block] > .probe")) {
    const [, start, reach] = /^M(-?[\d.]+ -?[\d.]+)h(-?[\d.]+)/.exec(flag.getAttribute("d") ?? "") ?? [];
    if (start) flags.set(start, Math.abs(Number(reach)) + 8);
  }
  for (const wire of /** @type {NodeListOf<SVGGElement>} */ (drawing.querySelectorAll(".named > .wire"))) {
    const start = startOf(wire);
    if (start) flags.set(`${start.x} ${start.y}`, start.reach);
  }
  return flags;
}
