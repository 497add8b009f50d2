// One plot for each probe: the trace, a frozen run behind it, zoom by dragging, a cursor that all plots share.

import { scaleFor, shown, timeLabels, timeText } from "./figures.mjs";
import { dragged, moved } from "./gestures.mjs";

/**
 * @typedef {import("./figures.mjs").Scales} Scales
 * @typedef {import("./engine.mjs").Probe} Probe
 * @typedef {{signal: string, x: Float64Array, y: Float64Array, frozen: Float64Array | null,
 *   frozenX: Float64Array | null}} Picture
 */

const HEIGHT = 170; // pixels
const FONT = '12px system-ui, "Segoe UI", "DejaVu Sans", sans-serif';

const TRUTH = [-0.15, 1.15]; // of an axis of bits
const PADDED = { pad: 0.1, soft: 0, mode: 3 }; // of other numbers, as uPlot does

/** The range of an axis: about a signal that is zero throughout, else as uPlot does.
 * @param {any} _ @param {number | null} low @param {number | null} high @returns {[number | null, number | null]} */
function spanned(_, low, high) {
  return low === 0 && high === 0 ? [-1, 1] : low === null ? [null, null] : uPlot.rangeNum(low, high, { min: PADDED, max: PADDED });
}

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
  constructor(place, probes, units, zoomed, looked, height = HEIGHT) {
    this.place = place;
    this.height = height;
    this.marked = NaN; // seconds that were looked at
    this.stretch = ""; // of which spectra are
    /** @type {[number, number]} */
    this.range = [0, 1]; // seconds that all plots show
    this.units = units;
    this.zoomed = zoomed;
    this.looked = looked;
    this.spectra = false;
    /** @type {Map<string, Chart>} */
    this.charts = new Map(probes.map((probe) => [probe.signal, new Chart(place, probe, this)]));
    this.width = place.clientWidth; // asked for once: after changes of the page it takes a layout
    this.observer = new ResizeObserver(() => {
      this.width = place.clientWidth;
      this.charts.forEach((chart) => chart.resize());
    });
    this.observer.observe(place);
    this.theme = matchMedia("(prefers-color-scheme: dark)");
    this.repaint = () => this.charts.forEach((chart) => chart.remake());
    this.theme.addEventListener("change", this.repaint);
  }

  /** Pixels that a trace has across. */
  get pixels() {
    return Math.max(100, Math.round(this.width * devicePixelRatio));
  }

  /** Mark a time in all plots. @param {number} seconds */
  mark(seconds) {
    this.marked = seconds;
    this.charts.forEach((chart) => chart.plot?.redraw(false));
  }

  /** @param {[number, number]} range  of frequencies */
  zoomSpectra(range) {
    const [min, max] = range;
    this.charts.forEach((chart) => chart.isSpectrum() && chart.plot?.setScale("x", { min, max }));
  }

  /** Pictures of wires that are recorded besides the probes. @param {Picture[]} pictures */
  drawWires(pictures) {
    for (const picture of pictures) {
      const chart = this.charts.get(picture.signal);
      if (chart?.recorded) chart.draw(picture, false);
    }
  }

  /** @param {Picture[]} pictures @param {boolean} spectra @param {string} stretch  of which spectra are */
  draw(pictures, spectra, stretch = "") {
    const changed = spectra !== this.spectra;
    this.spectra = spectra;
    this.stretch = stretch;
    for (const picture of pictures) this.charts.get(picture.signal)?.draw(picture, changed);
  }

  /** Plot one more signal. @param {Probe} probe @param {() => void} closed  hears that it shall go */
  add(probe, closed) {
    const chart = new Chart(this.place, probe, this);
    chart.recorded = true;
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
    this.recorded = false; // tick by tick, besides the probes
    this.figure = document.createElement("figure");
    this.figure.tabIndex = 0;
    this.figure.title = "Arrows move, + and − zoom, 0 shows all";
    this.figure.addEventListener("keydown", (event) => this.key(event));
    this.caption = document.createElement("figcaption");
    this.caption.append(strong(probe.signal));
    this.figure.append(this.caption);
    place.append(this.figure);
    /** @type {any} */
    this.plot = null;
    this.factor = 1;
    this.said = ""; // in the caption
    /** @type {HTMLOutputElement | null} */
    this.reading = null;
    /** @type {Picture | null} */
    this.picture = null;
  }

  /** Whether densities are shown; of wires that are recorded besides the probes there are none. */
  isSpectrum() {
    return this.all.spectra && !this.probe.shape.length && !this.recorded;
  }

  /** @param {Picture} picture @param {boolean} anew */
  draw(picture, anew) {
    this.picture = picture;
    const most = Math.max(largest(picture.y), picture.frozen ? largest(picture.frozen) : 0);
    const { exponent, text } = scaleFor(this.all.units[this.probe.unit], most);
    const unit = this.isSpectrum() ? `${text || "1"}/√Hz` : text;
    this.factor = 10 ** -exponent;
    const of = this.isSpectrum() && this.all.stretch ? `${this.all.stretch}. ` : "";
    const about = [unit ? ` in ${unit}` : "", of + this.probe.doc];
    if (String(about) !== this.said) this.caption.replaceChildren(strong(this.probe.signal), about[0], soft(about[1]));
    this.said = String(about);
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
    const label = time ? undefined : spectrum ? "frequency in Hz" : "entry";
    const labels = (/** @type {any} */ _, /** @type {number[]} */ at) => (time ? timeLabels(at) : at.map(tick));
    const whole = (/** @type {number} */ value) => (Number.isInteger(Math.log10(value)) ? value : null);
    const decades = (/** @type {any} */ _, /** @type {number[]} */ at) => at.map(whole);
    if (spectrum) Object.assign(axis, { filter: decades, grid: { ...axis.grid, filter: decades } });
    const truth = this.probe.type === "bool" && !spectrum;
    const distr = spectrum ? 3 : 1, named = label && { label, labelSize: 18, labelFont: FONT };
    const options = {
      width: Math.max(200, this.all.width),
      height: this.all.height,
      legend: { show: false },
      cursor: { sync: { key: time ? "time" : spectrum ? "frequency" : this.probe.signal }, drag: { x: true, y: false, setScale: false } },
      scales: { x: { time: false, distr, ...(time && { range: () => this.all.range }) }, y: { distr, ...(!spectrum && { range: truth ? TRUTH : spanned }) } },
      axes: [
        { ...axis, ...named, size: 26, space: time ? 90 : 50, values: labels },
        truth
          ? { ...axis, size: 64, splits: () => [0, 1], values: () => ["false", "true"] }
          : { ...axis, size: 64, values: (/** @type {any} */ _, /** @type {number[]} */ at) => at.map(tick) },
      ],
      series: [{}, ...(data.length > 2 ? [before] : []), line],
      hooks: {
        setSelect: [(/** @type {any} */ plot) => this.select(plot, time)],
        setCursor: [(/** @type {any} */ plot) => this.read(plot)],
        draw: [(/** @type {any} */ plot) => time && this.drawMark(plot)],
      },
    };
    this.plot = new uPlot(options, data, this.figure);
    this.plot.over.addEventListener("click", () => {
      const at = this.plot.cursor.left;
      if (time && at >= 0) this.all.looked(this.plot.posToVal(at, "x"));
    });
    this.plot.over.addEventListener("dblclick", () => (time ? this.all.zoomed(null) : this.all.repaint()));
    dragged(this.plot, () => this.select(this.plot, time));
  }

  /** @param {any} plot @param {boolean} time */
  select(plot, time) {
    if (plot.select.width < 3) return;
    const range = [plot.posToVal(plot.select.left, "x"), plot.posToVal(plot.select.left + plot.select.width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    if (time) this.all.zoomed(/** @type {[number, number]} */ (range));
    else this.all.zoomSpectra(/** @type {[number, number]} */ (range));
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { min, max } = this.plot?.scales.x ?? {};
    if (this.isSpectrum() || this.probe.shape.length || !(max > min)) return;
    const about = this.all.marked > min && this.all.marked < max ? this.all.marked : (min + max) / 2;
    const range = moved(event, [min, max], about);
    if (range === undefined) return;
    event.preventDefault();
    this.all.zoomed(range);
  }

  /** A line at the time that was looked at. @param {any} plot */
  drawMark(plot) {
    const { min, max } = plot.scales.x, { left, top, width, height } = plot.bbox;
    if (!(this.all.marked >= min && this.all.marked <= max)) return;
    const x = left + ((this.all.marked - min) / (max - min)) * width;
    plot.ctx.save();
    plot.ctx.strokeStyle = colour("--orange");
    plot.ctx.lineWidth = devicePixelRatio;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  /** The value under the cursor, beside the name. @param {any} plot */
  read(plot) {
    const at = plot.cursor.idx;
    this.reading ??= this.figure.appendChild(document.createElement("output"));
    if (at === null || at === undefined || !this.picture) {
      this.reading.textContent = "";
      return;
    }
    const values = plot.data[plot.data.length - 1], value = values[at], x = plot.data[0][at];
    const said = (/** @type {number} */ one) => shown(one / this.factor, this.all.units[this.probe.unit]);
    if (value === null || value === undefined || Number.isNaN(value)) return void (this.reading.textContent = "");
    const time = !this.isSpectrum() && !this.probe.shape.length;
    const place = time ? timeText(x) : `${Number(x.toPrecision(9))}${this.isSpectrum() ? " Hz" : ""}`;
    const from = time && this.all.marked >= plot.data[0][0] ? plot.valToIdx(this.all.marked) : -1;
    const since = from < 0 ? "" : `, Δ ${said(value - values[from])} in ${timeText(x - plot.data[0][from])}`;
    this.reading.textContent = `${said(value)} at ${place}${since}`;
  }

  resize() {
    this.plot?.setSize({ width: Math.max(200, this.all.width), height: this.all.height });
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
