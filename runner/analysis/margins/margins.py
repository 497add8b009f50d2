"""Stability margins of the loops of a graph, from its exact linearisation.

The verdict comes from the closed-loop poles alone, those the loop sees (`modes`). Of a stable loop:

- gain margin: the factors next to 1, above and below, which put a pole on the unit circle, -1 / L where L is real;
- phase margin: the least phase, of either sign, that does, |arg(-L)| where |L| = 1; delay margin: the least delay,
  (arg(-L) modulo 2 pi) / w;
- sensitivity peak Ms = max |S|, S = 1 / (1 + L); disk margin 2 / max |S - T| (Seiler, Packard and Gahinet, IEEE
  Control Systems 40, 2020, 78), which holds for gain and phase together;
- bandwidth: where |T| falls by 3 dB, T = L / (1 + L).

Any loop has crossovers, a least distance of L from -1, and the factors at the wire with which it
would be stable.

Crossovers and peaks are real roots of polynomials that are known exactly (`rational`, `axis`,
`scalar`). Where a loop has several values of its wire in a common period and more than one of them
matters, no single L exists: `lifted`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.graphs.model.loops import PEAKS, REQUIREMENTS
from proofmass.runner.analysis.linearisation.numbers import time_text
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import Pole, Verdict
from proofmass.runner.analysis.linearisation.rounded import NEAR, known_note, moved_maps, nearest_mode
from proofmass.runner.analysis.margins import lifted, lifted_modes, scalar
from proofmass.runner.analysis.margins.delays import delay_margin
from proofmass.runner.analysis.margins.figures import Figures, decibels
from proofmass.runner.analysis.margins.frequencies import check_by_sweep
from proofmass.runner.analysis.margins.known_limits import known_parts, limits_note
from proofmass.runner.analysis.margins.modes import Mode, seen
from proofmass.runner.host.arrays import Complex
from proofmass.runner.host.notebook import Plotted, html_table
from proofmass.runner.output.json_text import finite

if TYPE_CHECKING:
    import pandas

_LARGEST = 64  # states of which the open loop's poles are looked at where rounding may move them


@dataclass(frozen=True, eq=False, kw_only=True)
class Margins(Figures, Plotted):
    """The figures of one loop, its verdict, and what that rests on.

    >>> from proofmass import margins, read_graph
    >>> found = margins(read_graph("library:closed_loop_accelerometer"))
    >>> found
    <Margins of main: stable, gain margin 31.57 dB, phase margin 90.89 deg>
    >>> found.stable, found.poles.shape
    (True, (5,))
    """

    loop: str  # its name
    open_at: str  # the output at which it is opened
    verdict: Verdict  # "stable", "marginal" or "unstable"
    slowest: tuple[Pole, ...]  # closed-loop poles over its period the loop sees, slowest first
    hidden: tuple[Mode, ...]  # modes that do not decay and that the loop does not see
    period: float  # s; 0 of a continuous loop
    sample: float  # s, of the wire
    system: OpenLoop  # the open loop in state space
    elsewhere: Mapping[str, float] = field(default_factory=dict)  # the worst of what a loop may require, at others

    @property
    def stable(self) -> bool:
        """True if the verdict is "stable"."""
        return self.verdict == "stable"

    @property
    def poles(self) -> Complex:
        """Closed-loop poles over the period that the loop sees, the slowest first."""
        return np.array([pole.value for pole in self.slowest], dtype=complex)

    def required(self) -> dict[str, float]:
        """Return what a loop may require, the worst there is if it is not stable."""
        if self.stable:
            return super().required()
        return {name: math.inf if name in PEAKS else -math.inf for name in REQUIREMENTS}

    def attained(self, name: str) -> float:
        """A margin of a stable loop by the name and in the unit of its requirement; without limit it is infinite.

        It is the worst of those at other phases of an oscillation, or instants ahead, that were
        looked at.
        """
        return self.elsewhere.get(name, self.value(name))

    def __repr__(self) -> str:
        """The loop, its verdict and its margins, in a line."""
        numbers = {
            "gain margin": self.nearest_gain and f"{self.least_gain_margin:.2f} dB",
            "phase margin": self.phase_margin and f"{math.degrees(self.phase_margin):.2f} deg",
        }
        shown = "".join(f", {name} {value}" for name, value in numbers.items() if value)
        return f"<Margins of {self.loop}: {self.verdict}{shown}>"

    def to_pandas(self) -> "pandas.Series":
        """Return the figures by name, in the units named; NaN for a margin without limit."""
        need("pandas")
        # start-up time: pandas takes 0.5 s
        import pandas

        figures = {name: value for name, value in self.as_data().items() if value is None or isinstance(value, float)}
        return pandas.Series(figures, name=self.loop, dtype=float)

    def _repr_html_(self) -> str:
        figures: list[tuple[str, float | None, str]] = [
            ("gain margin", decibels(self.gain_margin), "dB"),
            ("gain reduction", decibels(self.gain_reduction), "dB"),
            ("phase margin", None if self.phase_margin is None else math.degrees(self.phase_margin), "deg"),
            ("delay margin", self.delay_margin, "s"),
            ("disk margin", self.disk_margin, "1"),
            ("sensitivity peak", decibels(self.sensitivity_peak), "dB"),
            ("bandwidth", self.bandwidth, "Hz"),
        ]
        rows = [(name, "no limit" if value is None else in_print(value, unit)) for name, value, unit in figures]
        return html_table((), [("verdict", self.verdict), *rows], f"loop {self.loop}, opened at {self.open_at}")

    def as_data(self) -> dict[str, Any]:
        """The numbers as plain data, in the units of their names."""
        samples = None if self.delay_margin is None or not self.sample else self.delay_margin / self.sample
        return {
            "loop": self.loop,
            "open_at": self.open_at,
            "stable": self.stable,
            "verdict": self.verdict,
            "operating_point": {
                "tick": self.system.map.tick,
                "time_s": self.system.map.time,
                "found": self.system.map.told,
            },
            "notes": list(self.system.map.notes),
            "hidden_modes": [str(mode) for mode in self.hidden],
            **super().as_data(),
            **{f"worst_{name}_{REQUIREMENTS[name].lower()}": finite(value) for name, value in self.elsewhere.items()},
            "delay_margin_samples": samples,
            "period_s": self.period,
            "sample_s": self.sample,
            "poles": [[pole.value.real, pole.value.imag] for pole in self.slowest],
            "pole_distances": [pole.distance for pole in self.slowest],
        }


def margins_of(system: OpenLoop, loop: str, open_at: str) -> Margins:
    """All margins of an open loop; of one that moves, at the instant at which it is nearest to its limits."""
    found = margins_at(system, loop, open_at)
    if not system.map.others or system.per_period > 1 or not found.stable:
        return found
    ahead = (replace(other.between(), told=system.map.told, others=()) for other in system.map.others)
    loops = [replace(system, map=other) for other in ahead if other.states == system.map.states]
    return least_of([found, *(margins_at(one, loop, open_at) for one in loops)])


def margins_at(system: OpenLoop, loop: str, open_at: str) -> Margins:
    """All margins of an open loop at its operating point."""
    single, quotient = system.single(), system.quotient
    if single is None or quotient is None:
        system, verdict, poles, hidden = lifted_modes.seen(system)
        figures = lifted.figures_of(system, verdict == "stable")
        if verdict == "stable":
            system, figures = over_stretches(system, figures)
    else:
        visible, verdict, poles, hidden = seen(system, quotient)
        axis = scalar.axis_of(visible, not system.continuous, [pole.value for pole in poles])
        figures = scalar.figures_of(axis, system.map.period, verdict == "stable")
        if system.per_period > 1 and verdict == "stable":
            figures = replace(figures, delay_margin=delay_margin(system, figures.gain_crossovers))
        poles_apart = [mode.pole for mode in hidden for _ in range(mode.times)]
        check_by_sweep(system, loop, axis.values, figures, poles_apart)
    return Margins(
        **vars(figures),
        loop=loop,
        open_at=open_at,
        verdict=verdict,
        slowest=poles,
        hidden=hidden,
        period=system.map.period,
        sample=system.sample,
        system=system,
    )


def with_rounding(found: Margins) -> Margins:
    """Return the margins of a loop, with a note on how well they are known where that is less than what is shown."""
    system = found.system
    small = len(system.map.states) <= _LARGEST and system.map.ticks is None
    opened = np.linalg.eigvals(system.matrices[0]) if small and not system.continuous else ()
    apart = math.inf if system.continuous else nearest_mode(np.array([*found.poles, *opened], dtype=complex))
    if not apart < NEAR:
        return found
    others = (replace(system, map=other) for other in moved_maps(system.map))
    moved = (_rounded(margins_at(other, found.loop, found.open_at)) for other in others)
    note = known_note(_rounded(found), moved, apart)
    return replace(found, system=system.noted(note)) if note else found


def _rounded(of: Margins) -> list[float | None]:
    """Return the figures that rounding moves."""
    limits = of.gain_margin, of.gain_reduction, of.phase_margin, of.delay_margin
    return [of.slowest[0].distance, *limits, *chain(*of.stable_gains)]


def least_of(instants: Sequence[Margins]) -> Margins:
    """Return the margins at the instant with the least gain margin, with a note on their range and
    those of the first, and the worst of each that a loop may require.

    Instants at which the loop is not stable have no margins; a note says that there are some.
    """
    stable = [one for one in instants if one.stable]
    worst, rows = min(stable, key=lambda one: one.least_gain_margin), [one.required() for one in stable]
    told = ranges(rows)
    first, last = instants[0].system.map, instants[-1].system.map
    notes = [
        *first.notes,
        f"it changes in the next {time_text(last.time - first.time)}; the least is shown: {told}",
    ]
    if len(stable) < len(instants):
        notes.append("it is unstable at some instants in that time, as if it stood still there")
    system = replace(worst.system, map=replace(worst.system.map, notes=tuple(notes)))
    return replace(worst, system=system, elsewhere=worst_of(rows))


def over_stretches(system: OpenLoop, figures: Figures) -> tuple[OpenLoop, Figures]:
    """Return a stable loop and its figures with the least margins of all stretches of its run.

    It has notes on their range, and on how well they are known.
    """
    loops = [system, *(OpenLoop(other.between()) for other in system.map.others)]
    stretches = [figures, *map(lifted.limits, loops[1:])]
    least = (
        max(stretches, key=lambda one: one.gain_reduction or 0.0),
        min(stretches, key=lambda one: one.gain_margin or math.inf),
        min(stretches, key=lambda one: math.inf if one.phase_margin is None else one.phase_margin),
    )
    names = "gain_reduction", "gain_margin", "phase_margin"
    worst = {name: getattr(one, name) for name, one in zip(names, least, strict=True)}
    told = ranges([{name: one.value(name) for name in names[1:]} for one in stretches])
    parts = [known_parts(*each) for each in zip(loops, stretches, strict=True)]
    shown = (parts[stretches.index(one)][kind] for kind, one in enumerate(least))
    notes = [f"the least of their margins is shown: {told}"] if told and len(loops) > 1 else []
    return system.noted(*notes, *limits_note(max(shown), max(map(max, parts)))), replace(figures, **worst)


def worst_of(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the worst of each of some values by name."""
    return {name: (max if name in PEAKS else min)(row[name] for row in rows) for name in rows[0]}


def ranges(rows: Sequence[Mapping[str, float]]) -> str:
    """Return the ranges of values by name that have limits, in words."""
    told = {name.replace("_", " "): _range([row[name] for row in rows], REQUIREMENTS[name]) for name in rows[0]}
    *others, last = [f"{name} {text}" for name, text in told.items() if text] or [""]
    return " and ".join(filter(None, [", ".join(others), last]))


def _range(values: Sequence[float], unit: str) -> str:
    """Return the least and the largest, or nothing if there is no limit."""
    least, most = min(values), max(values)
    if not math.isfinite(most):
        return ""
    return f"{time_text(least)} to {time_text(most)}" if unit == "s" else f"{least:.2f} to {most:.2f} {unit}"
