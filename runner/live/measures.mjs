// The table of measures, beside those of a frozen run.

import { element, named } from "./controls.mjs";
import { shown } from "./figures.mjs";

/**
 * @param {import("./engine.mjs").Measure[]} measures @param {Record<string, import("./figures.mjs").Scales>} units
 * @param {Record<string, number>} values @param {Record<string, number> | null} before  of the frozen run
 */
export function measureTable(measures, units, values, before) {
  const table = element("table"), head = table.createTHead().insertRow(), body = table.createTBody();
  for (const text of ["measure", "value", ...(before ? ["frozen", "change"] : []), ""]) head.append(element("th", { textContent: text }));
  for (const measure of measures) {
    const row = body.insertRow(), scales = units[measure.unit], value = values[measure.name], old = before?.[measure.name] ?? NaN;
    row.append(named("th", measure.name));
    row.insertCell().textContent = shown(value, scales);
    if (before) row.insertCell().textContent = shown(old, scales);
    if (before) row.insertCell().textContent = old ? `${(100 * (value / old - 1)).toFixed(2).replace("-", "−")}\u00a0%` : "";
    row.append(named("td", measure.read ? `${measure.statistic} of ${measure.signal}` : measure.signal));
  }
  return table;
}
