// Numbers for pictures: envelopes of long traces, spectra, numbers as people read them.

/**
 * @typedef {{exponent: number, text: string}[]} Scales  prefixes of a unit, the smallest first
 */

/**
 * The rows from `first` up to `last`, each or the lowest and highest of as many stretches as there are pixels, in the
 * order in which they come: an edge that falls is drawn falling.
 * Two traces of one grid have the same abscissae.
 * @param {Float64Array} values @param {number} first @param {number} last @param {number} pixels
 * @param {number} period  seconds from row to row
 * @param {number} late  time of the first row
 * @returns {{x: Float64Array, y: Float64Array}}
 */
export function envelope(values, first, last, pixels, period, late = 0) {
  const rows = last - first;
  if (rows <= 2 * pixels) {
    const x = new Float64Array(rows);
    for (let i = 0; i < rows; i++) x[i] = (first + i) * period + late;
    return { x, y: values.slice(first, last) };
  }
  const x = new Float64Array(2 * pixels), y = new Float64Array(2 * pixels);
  for (let pixel = 0; pixel < pixels; pixel++) {
    const from = first + Math.floor((pixel * rows) / pixels), to = first + Math.floor(((pixel + 1) * rows) / pixels);
    let low = Infinity, high = -Infinity, lowest = 0, highest = 0;
    const stop = Math.min(to, values.length);
    for (let row = from; row < stop; row++) {
      const value = values[row];
      if (value < low) [low, lowest] = [value, row];
      if (value > high) [high, highest] = [value, row];
    }
    const falls = highest < lowest;
    x[2 * pixel] = from * period + late;
    x[2 * pixel + 1] = ((from + to) / 2) * period + late;
    y[2 * pixel + (falls ? 1 : 0)] = low === Infinity ? NaN : low;
    y[2 * pixel + (falls ? 0 : 1)] = high === -Infinity ? NaN : high;
  }
  return { x, y };
}

const STAIRS = 300; // rows up to which a signal that holds its value is drawn as steps, as in the pictures of `run`

/**
 * A picture of a signal that holds each value until its next row, with the corners of its steps; unchanged if it holds
 * none, or has too many rows for steps to be seen.
 * @param {{x: Float64Array, y: Float64Array}} rows @param {boolean} held @param {number} period  seconds from row to row
 */
export function stepped(rows, held, period) {
  const count = rows.x.length;
  if (!held || !count || count > STAIRS) return rows;
  const x = new Float64Array(2 * count), y = new Float64Array(2 * count);
  for (let i = 0; i < count; i++) {
    x[2 * i] = rows.x[i];
    x[2 * i + 1] = i + 1 < count ? rows.x[i + 1] : rows.x[i] + period;
    y[2 * i] = y[2 * i + 1] = rows.y[i];
  }
  return { x, y };
}

const TIMES = /** @type {const} */ ([[1, "s"], [1e-3, "ms"], [1e-6, "us"], [1e-9, "ns"], [1e-12, "ps"]]);

/**
 * Labels of places on a time axis, in the unit of the largest, with the digits that tell neighbours apart.
 * @param {number[]} at  seconds, in equal steps
 * @returns {string[]}
 */
export function timeLabels(at) {
  const most = Math.max(...at.map(Math.abs)), step = at.length > 1 ? Math.abs(at[1] - at[0]) : most;
  const [size, unit] = TIMES.find(([size]) => most >= size * (1 - 1e-9)) ?? TIMES[TIMES.length - 1];
  const far = (/** @type {number} */ digits) =>
    at.some((value) => Math.abs(Number((value / size).toFixed(digits)) - value / size) > (1e-3 * step) / size);
  let digits = 0;
  while (digits < 15 && far(digits)) digits++;
  return at.map((value) => (value === 0 ? "0" : `${(value / size).toFixed(digits)} ${unit}`.replace("-", "−")));
}

/** A time in the unit that fits. @param {number} seconds @param {number} digits */
export function timeText(seconds, digits = 9) {
  const [size, unit] = TIMES.find(([size]) => Math.abs(seconds) >= size * (1 - 1e-9)) ?? TIMES[0];
  return `${String(Number((seconds / size).toPrecision(digits))).replace("-", "−")} ${unit}`;
}

/**
 * Amplitude density by Welch's method: Hann windows that overlap by half, eight of which fit side by side.
 * @param {Float64Array} values @param {number} rate  in Hz
 * @returns {{x: Float64Array, y: Float64Array} | null}  lines above zero; null for a signal that is too short
 */
export function spectrum(values, rate) {
  const count = values.length;
  if (count < 16) return null;
  const length = Math.max(16, 2 ** Math.floor(Math.log2(Math.max(1, Math.floor(count / 8)))));
  const window = Float64Array.from({ length }, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / length));
  const power = window.reduce((sum, weight) => sum + weight * weight, 0);
  const total = new Float64Array(length / 2 + 1);
  const real = new Float64Array(length), imaginary = new Float64Array(length);
  const table = turns(length);
  let segments = 0;
  for (let first = 0; first + length <= count; first += length / 2, segments++) {
    let mean = 0;
    for (let i = 0; i < length; i++) mean += values[first + i];
    mean /= length;
    for (let i = 0; i < length; i++) real[i] = window[i] * (values[first + i] - mean);
    imaginary.fill(0);
    transform(real, imaginary, table);
    for (let k = 0; k < total.length; k++) total[k] += real[k] * real[k] + imaginary[k] * imaginary[k];
  }
  const lines = length / 2;
  const x = new Float64Array(lines), y = new Float64Array(lines);
  for (let k = 1; k <= lines; k++) {
    x[k - 1] = (k * rate) / length;
    y[k - 1] = Math.sqrt((total[k] * (k === lines ? 1 : 2)) / (segments * rate * power));
  }
  return { x, y };
}

/** @param {number} length  @returns {{c: Float64Array, s: Float64Array}} */
function turns(length) {
  const angle = (/** @type {number} */ k) => (-2 * Math.PI * k) / length;
  const c = Float64Array.from({ length: length / 2 }, (_, k) => Math.cos(angle(k)));
  return { c, s: Float64Array.from({ length: length / 2 }, (_, k) => Math.sin(angle(k))) };
}

/** Fourier transform in place, of a power of two. @param {Float64Array} real @param {Float64Array} imaginary
 * @param {{c: Float64Array, s: Float64Array}} table  turns of this length */
function transform(real, imaginary, table) {
  const n = real.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      const r = real[i], m = imaginary[i];
      real[i] = real[j];
      imaginary[i] = imaginary[j];
      real[j] = r;
      imaginary[j] = m;
    }
  }
  for (let half = 1, step = n / 2; half < n; half *= 2, step /= 2) {
    for (let first = 0; first < n; first += 2 * half) {
      for (let k = 0; k < half; k++) {
        const at = first + k, other = at + half, c = table.c[k * step], s = table.s[k * step];
        const a = real[other] * c - imaginary[other] * s, b = real[other] * s + imaginary[other] * c;
        real[other] = real[at] - a;
        imaginary[other] = imaginary[at] - b;
        real[at] += a;
        imaginary[at] += b;
      }
    }
  }
}

/** The prefix for numbers up to `largest`. @param {Scales} scales @param {number} largest */
export function scaleFor(scales, largest) {
  const fitting = scales.filter(({ exponent }) => largest * (1 + 1e-9) >= 10 ** exponent);
  return fitting.length && largest > 0 && largest < Infinity ? fitting[fitting.length - 1] : plain(scales);
}

/** The unit without a prefix. @param {Scales} scales */
function plain(scales) {
  return scales.find(({ exponent }) => exponent === 0) ?? scales[0];
}

/** A number with so many digits and its unit. @param {number} value @param {Scales} scales @param {number} digits */
export function shown(value, scales, digits = 6) {
  if (!Number.isFinite(value)) return "none";
  const { exponent, text } = scaleFor(scales, Math.abs(value));
  const number = Number((value / 10 ** exponent).toPrecision(digits));
  return `${String(number).replace("-", "−")}${text ? ` ${text}` : ""}`;
}
