// Quantities as files have them: exact decimals with units, rounded once, and the fewest digits that are read back.

/** @typedef {{form: string, names: Record<string, [string, string]>[]}[]} Spelled  units that a field takes */
/** @typedef {[bigint, bigint]} Exact  numerator and denominator, which is positive */

const NUMBER = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d{1,3})?)\s*((?![.\d]).*?)$/i;
const WORD = /(?<![A-Za-zµμΩ])(?!sqrt\b)[A-Za-zµμΩ%][A-Za-zµμΩ0-9]*/gu;
const LONGEST_DECIMAL = 17; // of a float
const KEPT = 70; // bits of a quotient, more than a float has

/** @param {string} text  a decimal number @returns {Exact | null} */
function exactly(text) {
  const parts = /^([+-]?)(\d*)\.?(\d*)(?:e([+-]?\d+))?$/i.exec(text);
  if (!parts || !(parts[2] + parts[3])) return null;
  const power = Number(parts[4] ?? 0) - parts[3].length, ten = 10n ** BigInt(Math.abs(power));
  const digits = BigInt(parts[2] + parts[3]) * (parts[1] === "-" ? -1n : 1n);
  return power < 0 ? [digits, ten] : [digits * ten, 1n];
}

/** The float that is nearest. @param {Exact} of */
export function nearest([top, bottom]) {
  if (!top) return 0;
  const size = top < 0n ? -top : top;
  const shift = KEPT + bottom.toString(2).length - size.toString(2).length;
  const above = shift > 0 ? size << BigInt(shift) : size, below = shift < 0 ? bottom << BigInt(-shift) : bottom;
  const whole = above / below;
  const number = Number(whole * 2n + (above % below ? 1n : 0n)); // one bit more says that there is a rest
  const half = Math.trunc(shift / 2);
  return (top < 0n ? -number : number) * 2 ** -half * 2 ** (half - shift - 1);
}

/** @param {number} value @returns {Exact} */
function ofFloat(value) {
  let twos = 0;
  while (!Number.isInteger(value)) (value *= 2), twos++;
  return [BigInt(value), 1n << BigInt(twos)];
}

/** The fewest digits which, times a factor, are read back as this value. @param {number} value
 * @param {[string, string]} factor */
export function textIn(value, factor) {
  if (!value || !Number.isFinite(value)) return String(value || 0);
  const [times, over] = factor.map(BigInt), size = ofFloat(Math.abs(value)), sign = value < 0 ? "-" : "";
  const exact = /** @type {Exact} */ ([size[0] * over, size[1] * times]);
  const power = String(exact[0]).length - String(exact[1]).length, above = 10n ** BigInt(Math.abs(power));
  const reached = power < 0 ? exact[0] * above >= exact[1] : exact[0] >= exact[1] * above;
  for (let digits = 1; ; digits++) {
    const places = digits - (reached ? 1 : 0) - power, ten = 10n ** BigInt(Math.abs(places));
    const [top, bottom] = places > 0 ? [exact[0] * ten, exact[1]] : [exact[0], exact[1] * ten];
    const figures = (2n * top + bottom) / (2n * bottom);
    /** @type {Exact} */
    const back = places > 0 ? [figures * times, ten * over] : [figures * times * ten, over];
    if (digits >= LONGEST_DECIMAL || nearest(back) === Math.abs(value)) return sign + laid(String(figures), -places);
  }
}

/** The number of a text such as "5e-5 kg/s", as it stands there. @param {string} text */
export function numberIn(text) {
  return NUMBER.exec(text.trim())?.[1] ?? "";
}

/** Digits and their power of ten as a number. @param {string} figures @param {number} power */
function laid(figures, power) {
  const short = figures.replace(/0+$/, "") || "0", point = figures.length + power;
  if (point > 12 || point < -3) return `${short[0]}${short.length > 1 ? `.${short.slice(1)}` : ""}e${point - 1}`;
  if (point <= 0) return `0.${"0".repeat(-point)}${short}`;
  if (point >= short.length) return short + "0".repeat(point - short.length);
  return `${short.slice(0, point)}.${short.slice(point)}`;
}

/** What a unit that was typed is in the unit of a field; null for an unknown one. @param {string} typed
 * @param {Spelled} spelled @returns {Exact | null} */
function factorOf(typed, spelled) {
  const words = typed.match(WORD) ?? [], form = typed.replace(WORD, "?").replace(/\s+/g, "");
  for (const { form: known, names } of spelled) {
    if (known.replace(/\s+/g, "") !== form || names.length !== words.length) continue;
    const factors = words.map((word, i) => names[i][word]?.map(BigInt));
    if (!factors.every(Boolean)) continue;
    const times = (/** @type {number} */ side) => factors.reduce((all, one) => all * one[side], 1n);
    return [times(0), times(1)];
  }
  return null;
}

/** A text as a number in the coherent unit: with no unit in that of the field. @param {string} text
 * @param {string} shown  unit of the field @param {[string, string]} factor @param {Spelled} spelled
 * @returns {Exact | string}  or what is wrong with it */
export function quantity(text, shown, factor, spelled) {
  const [, number, typed] = NUMBER.exec(text.trim().replace("−", "-")) ?? [], exact = number ? exactly(number) : null;
  if (!exact) return "is not a number";
  const own = !typed || typed === shown ? /** @type {Exact} */ ([1n, 1n]) : factorOf(typed, spelled);
  if (!own) return `has the unit ${typed}: write it in ${shown === "1" ? "no unit" : shown}`;
  return [exact[0] * own[0] * BigInt(factor[0]), exact[1] * own[1] * BigInt(factor[1])];
}

/** Ticks of a run from 0 to a time, both ends included; null for what is no time. @param {string} text
 * @param {[number, number]} rate  numerator and denominator in Hz @param {Spelled} spelled  of seconds */
export function ticksOf(text, rate, spelled) {
  const time = quantity(text, "s", ["1", "1"], spelled);
  if (typeof time === "string" || time[0] < 0n) return null;
  return Number((time[0] * BigInt(rate[0])) / (time[1] * BigInt(rate[1]))) + 1;
}
