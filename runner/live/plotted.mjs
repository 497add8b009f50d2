// Wires that are plotted besides the probes, without being probed in the file.

/** Plot a wire, or no longer. @param {import("./view.mjs").View} view @param {string} name */
export function plot(view, name) {
  const { charts, plotted, model } = view, wire = model?.loop.wires.find((one) => one.name === name);
  if (!wire || !charts) return;
  const chart = charts.charts.get(name);
  if (chart && !plotted.has(name)) return chart.figure.scrollIntoView({ block: "nearest" });
  if (plotted.delete(name)) charts.drop(name);
  else {
    const { unit, doc, held } = wire;
    plotted.add(name);
    const probe = { signal: name, unit, doc, stride: 1, phase: 0, type: "float64", bytes: 8, held, shape: [], fraction: null };
    charts.add(probe, () => plot(view, name));
    view.say(`${name} is plotted; click it again to take it away`);
  }
  view.record();
}
