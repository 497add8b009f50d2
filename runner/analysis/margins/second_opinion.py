"""A second opinion on a loop by python-control: its poles, and the margins of its response over frequencies.

python-control gets the loop as a `StateSpace`. The verdict is that of the poles of `feedback`. Its
polynomial search for margins loses its digits beyond a few states, so `stability_margins` gets the
response over a grid that is dense at the poles. A grid shows no crossover at its ends, so the
response at 0 Hz, half the rate, and our crossovers counts too where it crosses there. A loop with a
long delay crosses with every turn of it: the grid ends after the first of these, and there are only
our crossovers on.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.analysis.linearisation.linearise import to_control
from proofmass.runner.analysis.linearisation.rational import LARGEST_CERTIFIED, Transfer
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.host.arrays import Array

_POINTS = 3000  # over all decades
_AT_A_POLE = 200  # on each side of it
_DECIBELS, _DEGREES = 0.01, 0.01  # what counts as agreement
_CROSSOVERS = 8  # of each kind, up to which `stability_margins` looks: it takes 20 ms for each
_MOST_STATES = 400  # of a loop whose poles it finds in a second
_ROUNDING = 1e-6  # of a response where it crosses


class SecondOpinion(NamedTuple):
    """Verdict and margins by python-control, or the reason why it has none."""

    loop: str
    stable: bool | None = None
    gain_margin_db: float | None = None  # from 0 dB to the factor next to 1; None without limit
    phase_margin_deg: float | None = None
    differences: tuple[str, ...] = ()
    reason: str = ""

    def as_data(self) -> dict[str, Any]:
        """Return the opinion as plain data."""
        return self._asdict() | {"differences": list(self.differences)}

    def __str__(self) -> str:
        """The opinion in a line."""
        if self.reason:
            return f"python-control has no opinion on {self.loop}: {self.reason}"
        said = "stable" if self.stable else "unstable"
        if self.stable:
            gain, phase = self.gain_margin_db, self.phase_margin_deg
            said += f", {'no gain limit' if gain is None else f'{gain:.2f} dB'}"
            said += f", {'no phase limit' if phase is None else f'{phase:.2f} deg'}"
        if self.differences:
            return f"python-control DISAGREES on {self.loop}: {said}; {', '.join(self.differences)}"
        return f"python-control agrees on {self.loop}: {said}"


def second_opinion(margins: Margins) -> SecondOpinion:
    """Return the verdict and the margins of a loop by python-control, and where they differ from ours.

    `margins` are ours, of the same loop. Gain margins are in dB, phase margins in deg. Where
    python-control has none that could be compared, the opinion gives the reason.
    Raises `ImportError` where python-control is damaged.

    >>> from proofmass import margins, read_graph, second_opinion
    >>> print(second_opinion(margins(read_graph("library:closed_loop_accelerometer"))))
    python-control agrees on main: stable, 31.57 dB, 90.89 deg
    """
    loop = margins.loop
    if margins.system.per_period > 1:
        return SecondOpinion(loop, reason=f"a period holds {margins.system.per_period:,} values of the wire")
    if margins.verdict == "marginal":
        return SecondOpinion(loop, reason="its poles lie on the boundary of stability, but for rounding")
    states = len(margins.system.map.states)
    if states > _MOST_STATES:
        return SecondOpinion(loop, reason=f"it would take long to find {states:,} poles")
    # start-up time: control takes 0.9 s
    import control

    system = to_control(margins.system.map, negated=True)
    closed: Any = control.feedback(system, 1)
    stable = _stable(closed.poles() if states else [], margins)
    verdict = () if stable == margins.stable else (f"we say {margins.verdict}",)
    if not (stable and margins.stable):
        return SecondOpinion(loop, stable, differences=verdict)
    quotient = margins.system.quotient
    many = quotient is not None and states > LARGEST_CERTIFIED and not margins.system.continuous
    gains, phases = _crossovers(
        control, _transfer(control, quotient, margins) if quotient and many else system, margins
    )
    gain = min((abs(20.0 * math.log10(factor)) for factor in gains), default=None)
    phase = min(map(abs, phases), default=None)
    our_gain = margins.least_gain_margin if margins.nearest_gain else None
    our_phase = None if margins.phase_margin is None else math.degrees(margins.phase_margin)
    of_gain = _difference("gain margin", gain, our_gain, "dB", _DECIBELS)
    of_phase = _difference("phase margin", phase, our_phase, "deg", _DEGREES)
    return SecondOpinion(loop, stable, gain, phase, of_gain + of_phase)


def _transfer(control: Any, quotient: Transfer, margins: Margins) -> Any:
    """Return a loop of many states by its coefficients: its state space takes seconds."""
    unit = int(quotient.denominator[quotient.denominator.degree()])
    parts = ([int(c) / unit for c in part.coeffs()[::-1]] for part in (quotient.numerator, quotient.denominator))
    return control.TransferFunction(*parts, margins.period)


def _difference(name: str, theirs: float | None, ours: float | None, unit: str, most: float) -> tuple[str, ...]:
    same = theirs is ours if theirs is None or ours is None else abs(theirs - ours) <= most
    return () if same else (f"our {name} is {'without limit' if ours is None else f'{ours:.2f} {unit}'}",)


def _stable(poles: Any, margins: Margins) -> bool:
    """Return whether all poles decay but those of modes that the loop does not see."""
    left = list(poles)
    for mode in margins.hidden:
        for _ in range(mode.times):
            left.remove(min(left, key=lambda pole: abs(pole - mode.pole.value)))
    return all(pole.real < 0.0 if margins.system.continuous else abs(pole) < 1.0 for pole in left)


def _crossovers(control: Any, system: Any, margins: Margins) -> tuple[list[float], list[float]]:
    """Return the factors and the degrees at all crossovers: those of a search, and ours where it crosses too."""
    top, grid = math.pi / system.dt if system.dt else math.inf, _grid(system, margins)
    response = control.frequency_response(system, grid, squeeze=True)
    data = (response.magnitude, np.degrees(response.phase), grid)
    gains, phases, *_ = control.stability_margins(data, returnall=True)
    crossings = [2.0 * math.pi * f for f in margins.phase_crossovers if math.isfinite(f)]
    values = _response(system, [0.0, *crossings, *([top] if system.dt else [])])
    values += [] if system.dt else [complex(system.D[0, 0])]
    factors = [1.0 / abs(v) for v in values if v.real < 0.0 and abs(v.imag) <= _ROUNDING * abs(v) < math.inf]
    values = _response(system, [2.0 * math.pi * f for f in margins.gain_crossovers])
    degrees = [math.degrees(np.angle(-v)) for v in values if abs(abs(v) - 1.0) <= _ROUNDING]
    return [*gains, *factors], [*phases, *degrees]


def _response(system: Any, frequencies: list[float]) -> list[complex]:
    points = [1j * w if not system.dt else np.exp(1j * w * system.dt) for w in frequencies]
    return [complex(system(point, warn_infinite=False)) for point in points]


def _grid(system: Any, margins: Margins) -> Array:
    """Return angular frequencies over all decades, and more of them around the frequency of each open-loop pole."""
    poles = system.poles().astype(complex)
    if system.dt:
        poles = np.log(poles[np.abs(poles) > 1e-12]) / system.dt
    ours = 2.0 * math.pi * np.array([*margins.gain_crossovers, *margins.phase_crossovers, 0.0])
    known = np.concatenate([np.abs(poles), ours[np.isfinite(ours)]])
    top = math.pi / system.dt if system.dt else 1e3 * max(known)
    low = 1e-2 * min([1e-3 * top, *known[known > 1e-9 * top]])
    if len(ours) > 2 * _CROSSOVERS:
        top = min(top, 1.05 * float(np.sort(ours)[2 * _CROSSOVERS]))
    parts = [np.geomspace(low, top, _POINTS)]
    for pole in poles[(poles.imag > 0.0) & (poles.imag < top)]:
        away = np.geomspace(max(abs(pole.real), 1e-9 * pole.imag) / 100.0, pole.imag, _AT_A_POLE)
        parts += [pole.imag + away, pole.imag - away]
    grid = np.unique(np.concatenate(parts))
    return np.asarray(grid[(grid >= low) & (grid < top)])
