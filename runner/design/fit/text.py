"""A fit report as text for people and as plain data for programs."""

import math
from collections.abc import Sequence
from typing import Any

from proofmass.runner.design.fit.fit import Fit, FitReport
from proofmass.runner.design.fit.scale import CONFIDENCE
from proofmass.runner.design.fit.starts import Arrivals
from proofmass.runner.output.json_text import finite
from proofmass.runner.output.text_table import text_table


def text(report: FitReport) -> str:
    """Return the comparison of the fits, their coefficients with intervals, and the findings."""
    readings = report.readings
    t, v = readings.temperature, readings.output
    lines = [
        f"{readings.source}: {len(t):,} rows, {_named(readings.temperature_name, readings.temperature_unit)} from"
        f" {t.min():.6g} to {t.max():.6g}, {_named(readings.output_name, readings.output_unit)} from {v.min():.6g} to"
        f" {v.max():.6g}",
        "",
    ]
    after = f"peak to peak, {report.before:.5g} before"
    head = ("model", "method", "RMSE", "R^2", after, "iterations")
    lines += text_table([head, *(_row(fit) for fit in report.fits)], left=(0, 1))
    known = [fit for fit in report.fits if fit.method != "alternation"]
    rows = [("model", "coefficient", "value", f"{CONFIDENCE:.0%} interval", "unit")]
    rows += [_coefficient(fit.model, *c) for fit in known for c in fit.coefficients]
    lines += ["", *text_table(rows, left=(0, 1)), ""]
    lines.append(
        f"near the optimum each iteration of the alternation reduces the error by a factor of only {report.rate:.4f}"
    )
    return "\n".join([*lines, *map(str, report.findings)])


def starts_text(arrivals: Sequence[Arrivals]) -> str:
    """Return how many starts of the grid reach the optimum, in how many steps, and which do not."""
    lines = []
    for method in arrivals:
        there = sorted(arrival.iterations for arrival in method.all if arrival.reached)
        lines.append(f"{method.method}: {len(there)} of {len(method.all)} starts reach the optimum")
        if there:
            lines[-1] += f", in {there[0]:,} to {there[-1]:,} iterations, {there[len(there) // 2]:,} in the middle"
        for arrival in method.all:
            if not arrival.reached:
                b1, b2 = arrival.start
                how = "stopped" if arrival.converged else "did not converge"
                lines.append(f"  not from b = ({b1:.4g}, {b2:.4g}): {how}, RMSE {arrival.rmse:.5g}")
    return "\n".join(lines)


def data(report: FitReport, arrivals: Sequence[Arrivals] = ()) -> dict[str, Any]:
    """Return the report as plain data; infinite numbers are null."""
    readings = report.readings
    answer: dict[str, Any] = {
        "source": readings.source,
        "rows": len(readings.output),
        "temperature": {"name": readings.temperature_name, "unit": readings.temperature_unit},
        "output": {"name": readings.output_name, "unit": readings.output_unit},
        "peak_to_peak": report.before,
        "fits": [_fit_data(fit) for fit in report.fits],
        "alternation_rate": report.rate,
        "determined": report.determined,
        "findings": [finding.as_data() for finding in report.findings],
    }
    if arrivals:
        answer["starts"] = {method.method: [arrival._asdict() for arrival in method.all] for method in arrivals}
    return answer


def _fit_data(fit: Fit) -> dict[str, Any]:
    known = fit.coefficients
    return {
        "model": fit.model,
        "method": fit.method,
        "coefficients": {c.name: {"value": c.value, "half_width": finite(c.half_width), "unit": c.unit} for c in known},
        "rmse": fit.rmse,
        "r_squared": fit.r_squared,
        "peak_to_peak": fit.after,
        "iterations": fit.iterations,
        "converged": fit.converged,
    }


def _row(fit: Fit) -> tuple[str, ...]:
    iterations = f"{fit.iterations:,}" + ("" if fit.converged else ", not converged")
    return fit.model, fit.method, f"{fit.rmse:.5g}", f"{fit.r_squared:.5f}", f"{fit.after:.5g}", iterations


def _coefficient(model: str, name: str, value: float, half: float, unit: str) -> tuple[str, str, str, str, str]:
    interval = f"+- {half:.2g}" if math.isfinite(half) else "not determined"
    return model, name, f"{value:.8g}", interval, unit


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name
