"""The result of a fit to recordings as text for people."""

import math
from collections.abc import Iterator

from proofmass.runner.design.identification.fitted import CONFIDENCE, Estimate, Fitted, OutputFit
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table

_CORRELATED = 0.9


def fitted_text(fitted: Fitted) -> str:
    """Return the values with intervals, how each output agrees, unknowns that are not identifiable, and notes."""
    head = ("parameter", "before", "fitted", f"{CONFIDENCE:.0%} interval", "unit", "")
    rows: list[tuple[str, ...]] = [head, *map(_row, fitted.estimates)]
    for level in fitted.levels:
        value = "no more than the others make" if level.value is None else f"{level.value:.6g}"
        rows.append((level.parameter, f"{level.before:.6g}", value, _half(level.half_width), level.unit, "noise"))
    lines = [_verdict(fitted), "", *text_table(rows, left=(0, 4, 5)), ""]
    outputs: list[tuple[str, ...]] = [("output", "rms left", "explained", "unit", "what is left")]
    outputs += [_output(output) for output in fitted.outputs]
    lines += [*text_table(outputs, left=(0, 3, 4)), ""]
    return "\n".join([*lines, *fitted.findings, *_correlated(fitted), *(f"note: {note}" for note in fitted.notes)])


def _verdict(fitted: Fitted) -> str:
    runs = f"{fitted.rows:,} values, {count(fitted.runs, 'run')}"
    if fitted.interrupted:
        return f"interrupted: the best so far; {runs}"
    state = "converged" if fitted.converged else "did not converge"
    several = f", {fitted.reached} of {fitted.starts} starts agree" if fitted.starts > 1 else ""
    return f"{state}{several}; {runs}"


def _row(estimate: Estimate) -> tuple[str, ...]:
    known = math.isfinite(estimate.half_width)
    value = f"{estimate.value:.8g}" if known else f"{estimate.value:.4g}"
    state = f"at its {estimate.at_bound} bound" if estimate.at_bound else "" if known else "not identifiable"
    unit = estimate.unit if estimate.unit != "1" else ""
    return estimate.name, f"{estimate.before:.6g}", value, _half(estimate.half_width), unit, state


def _half(width: float) -> str:
    return f"+- {width:.2g}" if math.isfinite(width) else "unknown"


def _output(output: OutputFit) -> tuple[str, ...]:
    test = output.whiteness
    left = "white"
    if not test.white:
        left = f"not white, lag 1: {test.autocorrelation[0]:+.2f}"
        left += f"; intervals are some {test.widening:.1f} times too narrow" if test.widening > 1.05 else ""
    unit = output.unit if output.unit != "1" else ""
    return output.signal, f"{output.rms:.5g}", f"{100.0 * output.explained:.4f} %", unit, left


def _correlated(fitted: Fitted) -> Iterator[str]:
    names = [estimate.name for estimate in fitted.estimates]
    for i, first in enumerate(names):
        for j in range(i):
            value = float(fitted.correlation[i, j])
            if abs(value) >= _CORRELATED:
                yield f"{names[j]} and {first} are correlated: {value:+.3f}"
