"""Exact derivatives of scale factor, bias and margins by every real parameter and named value of a graph.

Scale factor and bias are those of the settled graph, linear about its operating point: output =
bias + scale factor times input. A margin moves with its parameter so that a closed-loop pole stays
on the boundary of stability, the unit circle or the axis: with right and left vectors v, w of that
pole, d pole = w* dA v / (w* v) (Golub and Van Loan, Matrix Computations, 7.2.2).
"""

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.linalg

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.model.dependence import Dependence, FormulaStep
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.graphs.model.targets import CLOCK_OFFSET, RATE
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.steady_state import SteadyState
from proofmass.runner.analysis.margins.margins import Margins, margins_at
from proofmass.runner.host.arrays import Complex
from proofmass.runner.plan.planned import Plan

_ROUNDING = 1e-12
_NEXT = 1e-6  # distance from the boundary of a pole that a critical factor puts there


@dataclass(frozen=True)
class Effect:
    """Effect of a parameter or named value on a quantity: the derivative, and the change where it
    is 1.01 times itself.

    A parameter that is zero has no percent: where it is a ratio the change is that for 0.01, else
    there is none.
    """

    parameter: str
    value: float
    unit: str
    derivative: float
    of_one_percent: float | None


@dataclass(frozen=True)
class Sensitivity:
    """A quantity and all that moves it, the strongest first."""

    quantity: str
    unit: str
    value: float
    effects: tuple[Effect, ...]
    undefined: tuple[str, ...] = ()  # those at a corner, of an infinite slope, or with a rate or integer behind them

    def as_data(self) -> dict[str, Any]:
        """The numbers as plain data."""
        effects = [vars(effect) for effect in self.effects]
        return {"quantity": self.quantity, "unit": self.unit, "value": self.value, "effects": effects} | (
            {"undefined": list(self.undefined)} if self.undefined else {}
        )


def transfer_sensitivities(about: Linearisation, source: Endpoint, target: Endpoint) -> tuple[Sensitivity, Sensitivity]:
    """Scale factor and bias from one output to another; raises `ModelError` where there is no steady state."""
    planned = about.plan
    period_map = about.map([source], [target, source], everything=True, by_parameters=True).seen()
    settled = SteadyState(planned, period_map, target)
    scale, bias = settled.values()
    slopes = {name: settled.slopes(name) for name in period_map.slopes}
    units = [planned.unit(node) for node in (target, source)]
    ratio = short_unit(f"({units[0]})/({units[1]})")
    by_scale, by_bias = ({name: pair[i] for name, pair in slopes.items()} for i in (0, 1))
    sizes = {name: settled.sizes(name) for name in slopes}
    of_scale, of_bias = ({name: pair[i] for name, pair in sizes.items()} for i in (0, 1))
    return (
        ranked(planned, "scale factor", ratio, scale, by_scale, period_map.undefined, sizes=of_scale),
        ranked(planned, "bias", units[0], bias, by_bias, period_map.undefined, settled.size, of_bias),
    )


def margin_sensitivities(planned: Plan, margins: Margins, system: OpenLoop) -> list[Sensitivity]:
    """Gain, phase and delay margin of a loop; `system` is its open loop with the derivatives by parameters."""
    if system.map.others and system.per_period == 1:  # derivatives are those at the operating point
        margins = margins_at(system, margins.loop, margins.open_at)
    found = []
    if margins.nearest_gain is not None:
        found.append(("gain margin", "dB", margins.least_gain_margin, by_gain(system, margins)))
    if margins.phase_margin is not None and system.per_period == 1:
        phase, delay = _by_phase(system, margins)
        found.append(("phase margin", "deg", margins.value("phase_margin"), phase))
        found.append(("delay margin", "s", margins.delay_margin or 0.0, delay))
    elif margins.phase_margin is not None:  # a delay of whole values has no slope
        found.append(("phase margin", "deg", margins.value("phase_margin"), by_turn(system, margins)))
    undefined, parameters = system.map.undefined, system.map.slopes
    return [
        ranked(planned, f"{margins.loop}: {name}", unit, value, {p: slope(p) for p in parameters}, undefined)
        for name, unit, value, slope in found
    ]


def by_gain(system: OpenLoop, margins: Margins) -> Callable[[str], float]:
    """Derivative of the gain margin in decibels by each parameter, to the nearer side."""
    factor = margins.nearest_gain or 1.0
    frequency = margins.gain_margin_frequency if factor == margins.gain_margin else None
    to_decibels = 20.0 / math.log(10.0) / (factor if factor > 1.0 else -factor)
    near = None if frequency is None else 2.0 * math.pi * frequency
    by_factor, moved = _critical(system, factor, near)
    by_gain = moved(by_factor).real
    return lambda parameter: -moved(closed_slope(system, factor, parameter)).real / by_gain * to_decibels


def by_turn(system: OpenLoop, margins: Margins) -> Callable[[str], float]:
    """Derivative of the phase margin, in degrees, of a loop with several values in a period."""
    slopes = _by_lag(system, margins.phase_margin or 0.0)
    return lambda parameter: math.degrees(slopes(parameter)[0])


def _by_lag(system: OpenLoop, lag: float, w: float | None = None) -> Callable[[str], tuple[float, float]]:
    """Derivatives of a turn at the wire that puts a pole on the boundary, at w, and of w, by each parameter."""
    turn, period = cmath.exp(-1j * lag), 1.0 if system.continuous else system.map.period
    by_factor, moved = _critical(system, turn, w)
    by_lag = moved(-1j * turn * by_factor)

    def slopes(parameter: str) -> tuple[float, float]:
        by_parameter = moved(closed_slope(system, turn, parameter))
        change = -by_parameter.real / by_lag.real
        return change, (by_parameter.imag + by_lag.imag * change) / period

    return slopes


def _by_phase(system: OpenLoop, margins: Margins) -> tuple[Callable[[str], float], Callable[[str], float]]:
    """Derivatives of phase margin, in degrees, and delay margin by each parameter."""
    crossovers = [2.0 * math.pi * f for f in margins.gain_crossovers]
    lags = [(w, cmath.phase(-complex(system.response(w)))) for w in crossovers]
    at_phase, phase = min(lags, key=lambda pair: abs(pair[1]))
    w, lag = min(lags, key=lambda pair: (pair[1] % (2.0 * math.pi)) / pair[0])
    of_phase, of_delay = _by_lag(system, phase, at_phase), _by_lag(system, lag, w)

    def delay(parameter: str) -> float:
        change, shift = of_delay(parameter)
        return change / w - lag % (2.0 * math.pi) * shift / (w * w)

    return lambda parameter: math.degrees(math.copysign(1.0, phase) * of_phase(parameter)[0]), delay


def _critical(
    system: OpenLoop, factor: complex, w: float | None = None
) -> tuple[Complex, Callable[[Complex], complex]]:
    """Return the derivative of the closed matrix by a factor, and the move of its critical pole by a change of it.

    The move is turned so that its real part leaves the boundary of stability. The pole is the one
    that the factor puts there at an angular frequency. Without that it is that of all poles next to
    the boundary which the factor moves most: the others are hidden, as the phase of an oscillation
    is.
    """
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + factor * d)
    by_factor: Complex = np.asarray(-b @ inverse @ inverse @ c, dtype=complex)
    eigen: Any = scipy.linalg.eig  # its declared type leaves out the result with both vectors
    poles, left, right = eigen(system.closed(factor), left=True, right=True)
    if w is None:
        moved = np.abs(np.einsum("ij,ik,kj->j", left.conj(), by_factor, right) / np.sum(left.conj() * right, axis=0))
        apart = np.abs(poles.real if system.continuous else np.abs(poles) - 1.0)
        at = int(np.argmax(np.where(apart <= max(_NEXT, float(np.min(apart))), moved, -1.0)))
    else:
        place = 1j * w if system.continuous else cmath.exp(1j * w * system.map.period)
        at = int(np.argmin(np.abs(poles - place)))
    left_one, right_one = left[:, at].conj(), right[:, at]
    along = 1.0 + 0.0j if system.continuous else complex(poles[at]).conjugate()
    return by_factor, lambda change: along * complex(left_one @ change @ right_one / (left_one @ right_one))


def closed_slope(system: OpenLoop, factor: complex, parameter: str) -> Complex:
    """Derivative of the closed matrix by a parameter, with a factor at the wire."""
    _, b, c, d = system.matrices
    da, db, dc, dd = system.slopes(parameter)
    inverse = np.linalg.inv(np.eye(len(d)) + factor * d)
    change = db @ inverse @ c + b @ inverse @ dc - factor * b @ inverse @ dd @ inverse @ c
    return np.asarray(da - factor * change, dtype=complex)


def ranked(
    planned: Plan,
    quantity: str,
    unit: str,
    value: float,
    slopes: Mapping[str, float],
    undefined: tuple[str, ...],
    size: float = 0.0,
    sizes: Mapping[str, float] = MappingProxyType({}),
) -> Sensitivity:
    """Return a quantity, its strongest effect first; what rounding leaves of numbers of some size counts as zero.

    `sizes` are those of which derivatives are sums. Parameters at zero have no change that would
    have the unit of the quantity: their derivatives are compared with these.
    """
    values = Dependence(planned.graph.root)
    no_slope = [value for value in values.numbers if _has_no_slope(planned, values, value, undefined)]
    by_value = {name: slope for name, slope in _slopes_by_values(values, slopes).items() if name not in no_slope}
    effects = [_effect(planned, name, slope) for name, slope in slopes.items()]
    effects += [_with_percent(n, values.numbers[n], values.units[n], slope) for n, slope in by_value.items()]
    changes = {e: abs(e.derivative if e.of_one_percent is None else e.of_one_percent) for e in effects}
    rounding = _ROUNDING * max(abs(value), size, *(abs(e.of_one_percent) for e in effects if e.of_one_percent))
    without = {e: _ROUNDING * sizes[e.parameter] for e in effects if e.of_one_percent is None and e.parameter in sizes}
    kept = [effect for effect in effects if changes[effect] > without.get(effect, rounding)]
    kept.sort(key=lambda e: (e.of_one_percent is None, -changes[e], e.parameter))
    return Sensitivity(quantity, unit, value if abs(value) > rounding else 0.0, tuple(kept), (*undefined, *no_slope))


def _has_no_slope(planned: Plan, values: Dependence, value: str, undefined: tuple[str, ...]) -> bool:
    """Return whether a value moves a parameter without a derivative, or what no derivative counts."""
    followers = values.followers([value])
    jumps = (not _is_smooth(planned, step) for step in followers if step.target not in values.numbers)
    return any(jumps) or not values.slopes(value).keys().isdisjoint(undefined)


def _is_smooth(planned: Plan, step: FormulaStep) -> bool:
    """Return whether derivatives count what a formula moves: no rate or clock offset, integer or circuit."""
    name, entry = split(step.target)
    if step.fixed:
        return entry not in (RATE, CLOCK_OFFSET)
    kind = type(planned.blocks[name])
    return kind.parameters[entry.partition("[")[0]].kind is not int and not kind.has_formats()


def _effect(planned: Plan, key: str, slope: float) -> Effect:
    name, entry = split(key)
    parameter, _, index = entry.rstrip("]").partition("[")
    block = planned.blocks[name]
    value = getattr(block, parameter)
    value = float(value[int(index)] if index else value)
    unit = short_unit(unit_of(block, type(block).parameters[parameter]))
    return _with_percent(key, value, unit, slope)


def _with_percent(key: str, value: float, unit: str, slope: float) -> Effect:
    one_percent = 0.01 * value if value else 0.01 if unit == "1" else None
    return Effect(key, value, unit, slope, None if one_percent is None else slope * one_percent)


def _slopes_by_values(dependence: Dependence, slopes: Mapping[str, float]) -> dict[str, float]:
    """Return the derivative by each value that moves a parameter with a derivative."""
    by_value = {}
    for value in dependence.numbers:
        terms = [slope * slopes[name] for name, slope in dependence.slopes(value).items() if name in slopes]
        if terms:
            by_value[value] = sum(terms)
    return by_value
