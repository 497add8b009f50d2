"""A noise budget, and a value that differs from run to run, as text for people."""

import math

from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit, word_of
from proofmass.runner.analysis.margins.text import sensitivity_text
from proofmass.runner.analysis.noise.noise_budget import ROWS, SMALL_MISFIT, NoiseBudget
from proofmass.runner.analysis.noise.over_runs import ValueDeviation


def value_text(found: ValueDeviation) -> str:
    """Return the value of an output at a time with its deviation over runs, and that of each source, for people."""
    unit = f" {found.unit}" if found.unit != "1" else ""
    whole = found.deviation**2
    lines = [
        f"{found.output} at {found.time:.6g} s: {found.value:.6g}{unit},"
        f" from run to run +-{found.deviation:.4g}{unit} rms",
        f"  {'source':<28} {'rms' + unit:>16} {'share':>8}",
    ]
    lines += [f"  {name:<28} {rms:16.5g} {100.0 * rms**2 / whole:7.2f} %" for name, rms in found.sources.items()]
    return "\n".join([*lines, *(f"  note: {note}" for note in found.notes)])


def noise_text(budget: NoiseBudget) -> str:
    """A budget for people: a row for each source, and what it amounts to."""
    unit = f" {budget.unit}" if budget.unit != "1" else ""
    low, high = budget.band
    lines = [
        f"noise of {budget.output}, {low:g} Hz to {high:g} Hz: {budget.rms:.6g}{unit} rms",
        f"  {'source':<28} {'kind':<20} {'rms' + unit.join(('', '')):>12} {'share':>8}",
    ]
    for source in budget.sources[:ROWS]:
        doubtful = "  ?" if source.doubtful else ""
        lines.append(
            f"  {source.block:<28} {source.kind:<20} {source.rms:12.5g} {100.0 * source.share:7.2f} %{doubtful}"
        )
    more = len(budget.sources) - ROWS
    lines += [f"  and {more} more"] if more > 0 else []
    lines += _coefficients(budget)
    return "\n".join([*lines, *(f"  note: {note}" for note in budget.notes)])


def derivatives_text(budget: NoiseBudget) -> list[str]:
    """The parameters that move the rms, and what one more of each whole number does."""
    if budget.derivatives is None:
        return []
    steps = [
        f"  {step.parameter:<32} {step.change:+12.4g}  for {step.value + 1} instead of {step.value}"
        for step in budget.steps
    ]
    return [sensitivity_text(budget.derivatives), *steps]


def _coefficients(budget: NoiseBudget) -> list[str]:
    """White level, bias instability and random walk, at the input where there is one."""
    unit = budget.referred_unit
    lines = [f"referred to {budget.input}" if budget.input else f"density of {budget.output}"]
    lines += [_density(budget, share) for share in (0.0, 0.5, 1.0)]
    levels = budget.levels
    if levels.misfit > SMALL_MISFIT:
        lines.append(f"  N, B, K and Q do not describe it: {levels.misfit:.1f} dB off; name a narrower --band")
        return lines
    for level in levels.levels:
        value = in_field_unit(level.name, level.value, unit)
        if level.value:
            lines.append(f"  {level.name}  {word_of(level.name, unit):<26} {value:.5g} {field_unit(level.name, unit)}")
    return lines


def _density(budget: NoiseBudget, share: float) -> str:
    """Amplitude density at a place on the logarithmic axis of frequency."""
    place = round(share * (len(budget.frequencies) - 1))
    value = in_field_unit("density", math.sqrt(float(budget.referred_density[place])), budget.referred_unit)
    unit = field_unit("density", budget.referred_unit)
    return f"  at {budget.frequencies[place]:<12.5g} Hz {'':<11} {value:.5g} {unit}"
