"""Margins of a loop whose orbit does not come back, over several stretches of its run: the least, and their range."""

import math
from collections.abc import Sequence
from dataclasses import replace

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins import lifted
from proofmass.runner.analysis.margins.figures import Figures, least_gain_margin


def over_stretches(system: OpenLoop, figures: Figures) -> tuple[OpenLoop, Figures]:
    """Return a stable loop with a note on the range of its margins, and its figures with the least of them."""
    others = [OpenLoop(other.between()) for other in system.map.others]
    limits = [lifted.limits(gains) for gains in (figures.stable_gains, *map(lifted.stable_gains, others))]
    reductions, margins = zip(*limits, strict=True)
    turns = [figures.phase_margin, *map(lifted.critical_turn, others)]
    phases = [math.inf if turn is None else turn for turn in turns]
    gain, phase = min(margins), min(phases)
    worst = figures.with_values(
        gain_margin=gain if math.isfinite(gain) else None,
        gain_reduction=max(reductions) or None,
        phase_margin=phase if math.isfinite(phase) else None,
    )
    told = ranges([least_gain_margin(*pair) for pair in limits], phases)
    notes = (*system.map.notes, f"the least of their margins is shown: {told}") if told else system.map.notes
    return replace(system, map=replace(system.map, notes=notes)), worst


def ranges(gains: Sequence[float], turns: Sequence[float]) -> str:
    """Return the ranges of gain margins, in dB, and phase margins, in radians, that have limits, in words."""
    told = {"gain margin": _range(gains, "dB"), "phase margin": _range([math.degrees(turn) for turn in turns], "deg")}
    return " and ".join(f"{name} {text}" for name, text in told.items() if text)


def _range(values: Sequence[float], unit: str) -> str:
    """Return the least and the largest, or nothing if there is no limit."""
    return f"{min(values):.2f} to {max(values):.2f} {unit}" if math.isfinite(max(values)) else ""
