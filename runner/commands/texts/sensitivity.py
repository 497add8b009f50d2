"""Sensitivities of scale factor, bias and margins, computed and shown as ranked tables of parameters."""

from collections.abc import Mapping

from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.sensitivity import Sensitivity, margin_sensitivities, transfer_sensitivities

_ROWS = 12  # of a table of parameters


def sensitivities(points: OperatingPoints, loops: Mapping[str, Margins], source: str, target: str) -> list[Sensitivity]:
    """Return scale factor and bias from one output to another, and the margins of loops, with their derivatives."""
    planned = points.plan
    ends = node_of(planned, source), node_of(planned, target)
    quantities = list(points.answered(lambda about: transfer_sensitivities(about, *ends)))
    for margins in loops.values():
        if not margins.system.continuous:  # derivatives by parameters are those of sampled loops
            node = node_of(planned, margins.open_at)
            quantities += margin_sensitivities(planned, margins, points.loop(node, by_parameters=True))
    return quantities


def sensitivity_text(sensitivity: Sensitivity) -> str:
    """Return a ranked table of the parameters that move one quantity."""
    unit = f" {sensitivity.unit}" if sensitivity.unit != "1" else ""
    lines = [
        f"{sensitivity.quantity}: {sensitivity.value:.8g}{unit}",
        f"  {'parameter':<32} {'for +1 %':>12}  derivative",
    ]
    for effect in sensitivity.effects[:_ROWS]:
        change = f"{effect.of_one_percent:+.4g}" if effect.of_one_percent is not None else ""
        per = f" {sensitivity.unit} per {effect.unit}" if effect.unit != "1" else unit
        lines.append(f"  {effect.parameter:<32} {change:>12}  {effect.derivative:.6g}{per}")
    more = len(sensitivity.effects) - _ROWS
    lines += [f"  and {more} more"] if more > 0 else []
    lines += [f"  {name:<32} {'':>12}  none: a corner, or an infinite slope" for name in sensitivity.undefined]
    return "\n".join(lines)
