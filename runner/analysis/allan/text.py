"""Allan deviations and their coefficients as text for people."""

import numpy as np

from proofmass.runner.analysis.allan.deviations import Allan, Curve, Duration
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit, word_of
from proofmass.runner.analysis.allan.freedom import AllanStatistic
from proofmass.runner.analysis.allan.levels import Level

_MISFIT = 6.0  # dB, by which the density of a few lines may be off


def allan_text(of: Allan) -> str:
    """Coefficients and a row of the curve for each octave of averaging time, for people."""
    lines = [
        f"{of.name or 'signal'}: {of.values:,} values at {1.0 / of.period:.9g} Hz, {of.values * of.period:.6g} s",
        *(coefficient_text(level, of.unit) for level in of.levels.levels),
        *_misfit(of),
        f"  {'tau [s]':>12} {'Allan':>12}  {'95 %':^27} {'freedom':>8} {'Hadamard':>12} {'modified':>12}"
        f"  [{field_unit('B', of.unit)}]",
    ]
    curve = of.curves[AllanStatistic.ALLAN]
    for i in _octaves(curve):
        cells = [in_field_unit("B", float(v[i]), of.unit) for v in (curve.deviation, curve.low, curve.high)]
        others = [
            _at(of.curves[s], float(curve.taus[i]), of.unit) for s in (AllanStatistic.HADAMARD, AllanStatistic.MODIFIED)
        ]
        lines.append(
            f"  {curve.taus[i]:12.6g} {cells[0]:12.6g}  {cells[1]:12.6g} to {cells[2]:<11.6g} {curve.freedom[i]:8.1f}"
            + "".join(f" {other:>12}" for other in others)
        )
    return "\n".join(lines)


def duration_text(of: Duration) -> str:
    """The length of a recording that is needed, for people."""
    present = "is too short for it" if of.present_error is None else f"knows it to {100.0 * of.present_error:.2g} %"
    return (
        f"to know the Allan deviation at {of.tau:g} s to {100.0 * of.error:g} %, record {of.seconds:.4g} s"
        f" ({of.freedom:.3g} degrees of freedom); this recording of {of.present_seconds:.4g} s {present}"
    )


def coefficient_text(level: Level, unit: str) -> str:
    """A coefficient with its interval in the units of data sheets."""
    value, low, high = (in_field_unit(level.name, v, unit) for v in (level.value, level.low, level.high))
    text = f"{value:.4g}, {low:.4g} to {high:.4g}" if level.seen else f"not seen: below {high:.4g}"
    return f"  {level.name}  {word_of(level.name, unit):<26} {text} {field_unit(level.name, unit)}"


def _misfit(found: Allan) -> list[str]:
    off = found.levels.misfit
    return (
        [f"  note: N, B, K and Q do not describe it: {off:.1f} dB off; it holds more than noise"]
        if off > _MISFIT
        else []
    )


def _octaves(curve: Curve) -> list[int]:
    wanted = curve.taus[0] * 2.0 ** np.arange(0, np.log2(curve.taus[-1] / curve.taus[0]) + 1e-9)
    return sorted({int(np.argmin(np.abs(np.log(curve.taus / tau)))) for tau in wanted})


def _at(curve: Curve, tau: float, unit: str) -> str:
    found = curve.deviation[curve.taus == tau]
    return "".join(f"{in_field_unit('B', value, unit):.6g}" for value in found.tolist())
