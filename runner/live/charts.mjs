// One plot for each probe: the trace, a frozen run behind it, zoom by dragging, a cursor that all plots share.

import { scaleFor, shown, timeLabels } from "./figures.mjs";

/**
 * @typedef {import("./figures.mjs").Scales} Scales
 * @typedef {import("./engine.mjs").Probe} Probe
 * @typedef {{signal: string, x: Float64Array, y: Float64Array, frozen: Float64Array | null,
 *   frozenX: Float64Array | null}} Picture
 */

const HEIGHT = 190; // pixels
const FONT = '12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';

/** @param {string} name */
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** @param {Float64Array} values */
const largest = (values) => values.reduce((most, value) => Math.max(most, Math.abs(value) || 0), 0);

export class Charts {
  /**
   * @param {HTMLElement} place @param {Probe[]} probes @param {Record<string, Scales>} units
   * @param {(range: [number, number] | null) => void} zoomed
   * @param {(seconds: number) => void} looked  at a time, by a click
   */
  constructor(place, probes, units, zoomed, looked) {
    this.place = place;
    this.units = units;
    this.zoomed = zoomed;
    this.looked = looked;
    this.spectra = false;
    /** @type {Map<string, Chart>} */
    this.charts = new Map(probes.map((probe) => [probe.signal, new Chart(place, probe, this)]));
    this.observer = new ResizeObserver(() => this.charts.forEach((chart) => chart.resize()));
    this.observer.observe(place);
    this.theme = matchMedia("(prefers-color-scheme: dark)");
    this.repaint = () => this.charts.forEach((chart) => chart.remake());
    this.theme.addEventListener("change", this.repaint);
  }

  /** Pixels that a trace has across. */
  get pixels() {
    return Math.max(100, Math.round(this.place.clientWidth * devicePixelRatio));
  }

  /** @param {Picture[]} pictures @param {boolean} spectra */
  draw(pictures, spectra) {
    const changed = spectra !== this.spectra;
    this.spectra = spectra;
    for (const picture of pictures) this.charts.get(picture.signal)?.draw(picture, changed);
  }

  /** Plot one more signal. @param {Probe} probe @param {() => void} closed  hears that it shall go */
  add(probe, closed) {
    const chart = new Chart(this.place, probe, this);
    const close = Object.assign(document.createElement("button"), { type: "button", className: "close", textContent: "×", title: `Take ${probe.signal} away` });
    close.addEventListener("click", closed);
    chart.figure.append(close);
    this.charts.set(probe.signal, chart);
    this.place.prepend(chart.figure);
  }

  /** @param {string} signal */
  drop(signal) {
    const chart = this.charts.get(signal);
    chart?.plot?.destroy();
    chart?.figure.remove();
    this.charts.delete(signal);
  }

  remove() {
    this.observer.disconnect();
    this.theme.removeEventListener("change", this.repaint);
    this.charts.forEach((chart) => chart.plot?.destroy());
    this.place.replaceChildren();
  }
}

class Chart {
  /** @param {HTMLElement} place @param {Probe} probe @param {Charts} all */
  constructor(place, probe, all) {
    this.probe = probe;
    this.all = all;
    this.figure = document.createElement("figure");
    this.caption = document.createElement("figcaption");
    this.figure.append(this.caption);
    place.append(this.figure);
    /** @type {any} */
    this.plot = null;
    this.factor = 1;
    /** @type {HTMLOutputElement | null} */
    this.reading = null;
    /** @type {Picture | null} */
    this.picture = null;
  }

  /** Whether densities are shown; of wires that are recorded besides the probes there are none. */
  isSpectrum() {
    return this.all.spectra && !this.probe.shape.length && !this.figure.querySelector(".close");
  }

  /** @param {Picture} picture @param {boolean} anew */
  draw(picture, anew) {
    this.picture = picture;
    const most = Math.max(largest(picture.y), picture.frozen ? largest(picture.frozen) : 0);
    const { exponent, text } = scaleFor(this.all.units[this.probe.unit], most);
    const unit = this.isSpectrum() ? `${text || "1"}/√Hz` : text;
    this.factor = 10 ** -exponent;
    this.caption.replaceChildren(strong(this.probe.signal), unit ? ` in ${unit}` : "", soft(this.probe.doc));
    const data = this.data(picture);
    if (!this.plot || anew || this.plot.series.length !== data.length) this.make(data);
    else this.plot.setData(data, true);
  }

  /** @param {Picture} picture */
  data(picture) {
    const scaled = (/** @type {Float64Array} */ values) => values.map((value) => value * this.factor);
    if (!picture.frozen) return [picture.x, scaled(picture.y)];
    const [x, y, frozen] = joined(picture);
    return [x, scaled(frozen), scaled(y)];
  }

  /** @param {any[]} data */
  make(data) {
    this.plot?.destroy();
    const spectrum = this.isSpectrum();
    const time = !spectrum && !this.probe.shape.length;
    const axis = { stroke: colour("--soft"), font: FONT, grid: { stroke: colour("--rule"), width: 1 }, ticks: { show: false } };
    const line = { stroke: colour("--blue"), width: 1.25, points: { show: false }, spanGaps: false };
    const before = { ...line, stroke: colour("--soft"), width: 1 };
    const label = time ? "time" : spectrum ? "frequency in Hz" : "entry";
    const labels = (/** @type {any} */ _, /** @type {number[]} */ at) => (time ? timeLabels(at) : at.map(tick));
    const options = {
      width: Math.max(200, this.all.place.clientWidth),
      height: HEIGHT,
      legend: { show: false },
      cursor: { sync: { key: time ? "time" : spectrum ? "frequency" : this.probe.signal }, drag: { x: true, y: false, setScale: false } },
      scales: { x: { time: false, distr: spectrum ? 3 : 1 }, y: { distr: spectrum ? 3 : 1 } },
      axes: [
        { ...axis, label, labelSize: 18, labelFont: FONT, size: 26, space: time ? 90 : 50, values: labels },
        { ...axis, size: 64, values: (/** @type {any} */ _, /** @type {number[]} */ at) => at.map(tick) },
      ],
      series: [{}, ...(data.length > 2 ? [before] : []), line],
      hooks: {
        setSelect: [(/** @type {any} */ plot) => this.select(plot, time)],
        setCursor: [(/** @type {any} */ plot) => this.read(plot)],
      },
    };
    this.plot = new uPlot(options, data, this.figure);
    this.plot.over.addEventListener("click", () => {
      const at = this.plot.cursor.left;
      if (time && at >= 0) this.all.looked(this.plot.posToVal(at, "x"));
    });
    this.plot.over.addEventListener("dblclick", () => time && this.all.zoomed(null));
  }

  /** @param {any} plot @param {boolean} time */
  select(plot, time) {
    if (plot.select.width < 3) return;
    const range = [plot.posToVal(plot.select.left, "x"), plot.posToVal(plot.select.left + plot.select.width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (time) this.all.zoomed(/** @type {[number, number]} */ (range));
    else plot.setScale("x", { min: range[0], max: range[1] });
  }

  /** The value under the cursor, beside the name. @param {any} plot */
  read(plot) {
    const at = plot.cursor.idx;
    this.reading ??= this.figure.appendChild(document.createElement("output"));
    if (at === null || at === undefined || !this.picture) {
      this.reading.textContent = "";
      return;
    }
    const value = plot.data[plot.data.length - 1][at];
    const text = value === null || Number.isNaN(value) ? "" : shown(value / this.factor, this.all.units[this.probe.unit]);
    const x = plot.data[0][at];
    const unit = this.isSpectrum() ? " Hz" : this.probe.shape.length ? "" : " s";
    this.reading.textContent = text && `${text} at ${Number(x.toPrecision(9))}${unit}`;
  }

  resize() {
    this.plot?.setSize({ width: Math.max(200, this.all.place.clientWidth), height: HEIGHT });
  }

  remake() {
    if (this.picture) this.draw(this.picture, true);
  }
}

/** Both curves over the abscissae of either; the shorter one ends early. @param {Picture} picture */
function joined(picture) {
  const { x, y, frozen, frozenX } = picture;
  const other = /** @type {Float64Array} */ (frozen), abscissae = frozenX ?? x;
  const same = abscissae.length === x.length && abscissae.every((value, i) => value === x[i]);
  if (same) return [x, y, other];
  const all = Float64Array.from(new Set([...x, ...abscissae])).sort();
  return [all, placed(all, x, y), placed(all, abscissae, other)];
}

/** @param {Float64Array} all @param {Float64Array} x @param {Float64Array} y */
function placed(all, x, y) {
  const values = new Map(Array.from(x, (at, i) => [at, y[i]]));
  return all.map((at) => values.get(at) ?? NaN);
}

/** @param {number | null} value */
function tick(value) {
  return value === null ? "" : String(Number(value.toPrecision(6))).replace("-", "−");
}

/** @param {string} text */
function strong(text) {
  const made = document.createElement("strong");
  made.textContent = text;
  return made;
}

/** @param {string} text */
function soft(text) {
  const made = document.createElement("span");
  made.className = "soft";
  made.textContent = ` ${text}`;
  return made;
}
