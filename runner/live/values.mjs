// Named values: the parameters that follow from them, by the formulas of the graph and to the same bits.

/**
 * @typedef {number | string | any[]} Tree  a number, the name of a value, an operation with its arguments
 * @typedef {{numbers: Record<string, number>, steps: {target: string, tree: Tree, divisor: number}[]}} Named
 */

/** @type {Record<string, (...of: number[]) => number>} */
const OPERATIONS = {
  "+": (a, b) => a + b,
  "-": (a, b) => a - b,
  "*": (a, b) => a * b,
  "/": (a, b) => a / b,
  negative: (a) => -a,
  sqrt: (a) => Math.sqrt(a),
  abs: (a) => Math.abs(a),
  min: (a, b) => (a < b ? a : b),
  max: (a, b) => (a > b ? a : b),
};

/** @param {Tree} tree @param {Record<string, number>} numbers @returns {number} */
function evaluated(tree, numbers) {
  if (typeof tree === "number") return tree;
  if (typeof tree === "string") return numbers[tree];
  const [operation, ...rest] = tree;
  if (operation === "raised") {
    const power = multipliedOut(evaluated(rest[1], numbers), Math.abs(rest[0]));
    return rest[0] >= 0 ? power : 1 / power;
  }
  const known = OPERATIONS[operation];
  return known ? known(...rest.map((one) => evaluated(one, numbers))) : NaN;
}

/** A whole power by repeated squares. @param {number} base @param {number} exponent */
function multipliedOut(base, exponent) {
  let result = NaN, square = base, begun = false;
  for (let left = exponent; left; left >>= 1) {
    if (left & 1) {
      result = begun ? result * square : square;
      begun = true;
    }
    if (left > 1) square *= square;
  }
  return begun ? result : 1;
}

/** @param {Tree} tree @param {Set<string>} names @returns {boolean} */
function holds(tree, names) {
  return typeof tree === "string" ? names.has(tree) : Array.isArray(tree) && tree.slice(1).some((one) => holds(one, names));
}

/** The parameters of a run: those that follow from changed values, then those that are changed themselves.
 * @param {Named} named @param {Record<string, number>} changes  of values and parameters, by name
 * @returns {Record<string, number>} */
export function parametersOf(named, changes) {
  const numbers = { ...named.numbers }, moved = new Set(Object.keys(changes).filter((name) => name in numbers));
  for (const name of moved) numbers[name] = changes[name];
  /** @type {Record<string, number>} */
  const parameters = {};
  for (const { target, tree, divisor } of named.steps) {
    if (!moved.size || !holds(tree, moved)) continue;
    const value = evaluated(tree, numbers);
    const own = divisor === 1 ? value : value / divisor;
    if (target in numbers) {
      moved.add(target);
      numbers[target] = own;
    } else parameters[target] = own;
  }
  for (const [name, value] of Object.entries(changes)) if (!(name in numbers)) parameters[name] = value;
  return parameters;
}
