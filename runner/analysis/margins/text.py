"""The margins of a loop, and what moves them, as text for people."""

import math
from collections.abc import Sequence
from typing import Any

from proofmass.blocks.declaration.shown_units import prefix
from proofmass.runner.analysis.linearisation.poles import Pole
from proofmass.runner.analysis.margins.delays import is_at_least
from proofmass.runner.analysis.margins.figures import decibels
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.sensitivity import Sensitivity

BUT_ROUNDING = ", but for what rounding hides"
_ROWS = 12  # of a table of parameters
_SLOWEST = 3  # poles that are shown
_CROSSOVERS = 8  # of each kind
_IN_THE_LIMIT = ", in the limit of high frequencies"
_VERDICTS = {"stable": "stable", "marginal": "MARGINAL", "unstable": "UNSTABLE"}


def margins_text(margins: Margins) -> str:
    """Return the numbers of one loop: its verdict, then margins if stable, else the way back."""
    head = f"loop {margins.loop}" + (f", opened at {margins.open_at}" if margins.loop != margins.open_at else "")
    poles = [pole for pole in margins.slowest if pole.value.imag >= 0.0][:_SLOWEST]
    turns = [abs(margins.system.turn(pole.value)) for pole in poles] if margins.period else [0.0] * len(poles)
    slowest = "; ".join(pole_text(pole, margins.period, turn) for pole, turn in zip(poles, turns, strict=True))
    count, point = len(margins.slowest), margins.system.map
    rows = [(_VERDICTS[margins.verdict], f"slowest of {count} closed-loop poles: {slowest}" if count else "no poles")]
    rows += _limits(margins) if margins.stable else _way_back(margins)
    rows += [
        ("gain crossovers", _lowest(margins.gain_crossovers)),
        ("phase crossovers", _lowest(margins.phase_crossovers)),
        *(("left out", str(mode)) for mode in margins.hidden),
        ("linearised at", operating_point(point.tick, point.time, point.told)),
        *(("note", note) for note in margins.system.map.notes),
    ]
    return "\n".join([head, *(f"  {name:<17} {text}" for name, text in rows)])


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
    none = "none: a corner, or an infinite slope, or a rate or integer that follows"
    lines += [f"  {name:<32} {'':>12}  {none}" for name in sensitivity.undefined]
    return "\n".join(lines)


def _lowest(crossovers: Sequence[float]) -> str:
    """Return the lowest crossovers: a wire with many values in a period has a comb of them."""
    shown = ", ".join(map(hertz_text, crossovers[:_CROSSOVERS]))
    return (f"{shown} and higher ones" if len(crossovers) > _CROSSOVERS else shown) or "none"


def pole_text(pole: Pole, period: float, turn: float) -> str:
    """Return frequency, damping ratio and time constant of a closed-loop pole, whose mode turns by
    `turn` in a period.

    The period is 0 for a continuous loop, whose pole tells both itself.

    >>> pole_text(Pole(0.99 + 0j, 0.01, 1e-15), 1e-3, 0.0)
    'time constant 99.499 ms'
    >>> pole_text(Pole(1e-17 + 0j, 1.0, 1e-15), 1e-3, 0.0)
    'gone after a period'
    """
    if pole.distance == 1.0 and period:
        return "gone after a period"
    rate = math.log1p(-pole.distance) / period if period else -pole.distance
    turn = turn / period if period else abs(pole.value.imag)
    at = f"{hertz_text(turn / (2.0 * math.pi))}, " if turn else ""
    if pole.verdict == "marginal" or rate == 0.0:
        size = f"1 - |p| = {pole.distance:.2g}" if period else f"-Re p = {pole.distance:.2g} 1/s"
        return f"{at}neither decays nor grows ({size}, known to {pole.uncertainty:.1g})"
    damping = f"damping {-rate / math.hypot(rate, turn):.4g}, " if turn else ""
    return f"{at}{damping}{'time constant' if rate < 0.0 else 'grows by e in'} {seconds_text(1.0 / abs(rate))}"


def hertz_text(frequency: float) -> str:
    """Return a frequency in Hz.

    >>> hertz_text(5782.94)
    '5782.9 Hz'
    """
    return f"{frequency:.5g} Hz"


def seconds_text(seconds: float) -> str:
    """Return a time with a suitable prefix.

    >>> seconds_text(0.00076679), seconds_text(2.1272), seconds_text(0.0)
    ('766.79 us', '2.1272 s', '0 s')
    """
    factor, unit = prefix("s", abs(seconds))
    return f"{seconds * factor:.5g} {unit.replace('µ', 'u')}"


def _limits(margins: Margins) -> list[tuple[str, str]]:
    """Return margins, peak and bandwidth of a stable loop."""
    limits, peak_at = (margins.gain_margin, margins.gain_reduction), margins.sensitivity_peak_frequency
    place = "" if peak_at is None else f" at {hertz_text(peak_at)}" if math.isfinite(peak_at) else _IN_THE_LIMIT
    gain = [f"{decibels(limit):+.2f} dB (x {limit:.5g})" for limit in limits if limit is not None]
    others = [("stable with", _factors(margins))] if len(margins.stable_gains) > 1 else []
    return [
        ("gain margin", ", ".join(gain) or "no limit"),
        *others,
        ("phase margin", _or_none(margins.phase_margin, lambda v: f"{math.degrees(v):.2f} deg")),
        ("delay margin", _or_none(margins.delay_margin, lambda v: _delay(margins, v))),
        ("disk margin", _or_none(margins.disk_margin, lambda v: f"{v:.4g}")),
        ("sensitivity peak", _or_none(decibels(margins.sensitivity_peak), lambda v: f"{v:.2f} dB") + place),
        ("bandwidth", _or_none(margins.bandwidth, hertz_text)),
    ]


def _way_back(margins: Margins) -> list[tuple[str, str]]:
    """Return the gains that would make a loop stable, and its distance from -1."""
    rows = [
        ("stable with", _factors(margins) if margins.stable_gains else f"no factor at the wire{but_rounding(margins)}")
    ]
    if margins.distance is not None:
        rows.append(("distance", f"{margins.distance:.4g} from -1 at the least"))
    return rows


def but_rounding(margins: Margins) -> str:
    """Return the words behind a claim on a loop that rounding may hide the other way."""
    return BUT_ROUNDING * (margins.verdict == "marginal")


def _factors(margins: Margins) -> str:
    intervals = [f"{low:.5g} to {'any' if math.isinf(high) else f'{high:.5g}'}" for low, high in margins.stable_gains]
    return f"a factor of {', or '.join(intervals)}"


def _delay(margins: Margins, delay: float) -> str:
    text = seconds_text(delay)
    if not margins.sample:
        return text
    more = ", or more" if is_at_least(margins.system, margins.gain_crossovers, delay) else ""
    return f"{text} ({delay / margins.sample:.2f} samples){more}"


def operating_point(tick: int, time: float, told: str) -> str:
    """Return the place in a run at which loops are linearised, and how it was found."""
    return f"tick {tick:,}, t = {seconds_text(time)}" + (f": {told}" if told else "")


def _or_none(value: float | None, text: Any) -> str:
    return "no limit" if value is None else str(text(value))
