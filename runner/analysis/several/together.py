"""Disk margin for simultaneous perturbations: the room that all loops leave at once.

Each wire carries its own factor f = (1 + d / 2) / (1 - d / 2), |d| < a: gain and phase together
(Seiler, Packard and Gahinet, IEEE Control Systems 40, 2020, 78). With S = (I + L)^-1 of all wires
the loops stay stable up to

    a = 1 / max over w of mu(S - I / 2)

The structured singular value mu lies between two bounds, `structured`, which agree for up to three
loops. Where a period of the graph holds several values of a wire, its factor may change from one to
the next. Modes that no wire sees, such as the phase of an oscillation, are left out as they are of
a single loop.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.toml_reader import GraphSource
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO
from proofmass.runner.analysis.decisions.one_bit import loop_through_bits
from proofmass.runner.analysis.linearisation.analog_loop import analog_group
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import At, Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import loop_nodes, one_loop
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop, of_wires
from proofmass.runner.analysis.linearisation.poles import Verdict
from proofmass.runner.analysis.margins.frequencies import sweep
from proofmass.runner.analysis.margins.lifted_modes import seen
from proofmass.runner.analysis.several.structured import lower_bound, upper_bound
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

_BALANCES = 12  # rounds of a quick scaling
_ONE_WAY = 1e-12  # least part of a way back, by which scales stay numbers
_REFINED = 60  # steps of the search for a peak
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
_NARROW = 1e-5  # of a frequency, to which a peak is found: of its height a part of 1e-10
_CLOSE = 1e-7  # of bounds while a peak is looked for
_PEAKS = 4  # that are refined
MOST_VALUES = 256  # of all wires in a period: so many take half a minute
_TOO_MANY = "the loops have too many values in their common period to be perturbed together"
_WITHOUT_LIMIT = 1e9  # a factor that counts as infinite: at this frequency nothing comes back


@dataclass(frozen=True, eq=False, kw_only=True)
class Together:
    """The disk margin of several loops at once, and of each alone with the others closed."""

    loops: tuple[str, ...]
    open_at: tuple[str, ...]
    verdict: Verdict
    margin: float | None = None  # all factors up to it leave the loops stable; None if they are not
    reached: float | None = None  # a combination of factors of this size makes them unstable
    frequency: float | None = None  # Hz, where the margin is least
    factors: tuple[complex, ...] = ()  # of that combination, one for each wire; none if one is infinite
    alone: tuple[float, ...] = ()  # disk margin of each loop
    unstructured: float | None = None  # margin that perturbations between the wires would leave
    frequencies: Array = field(default_factory=lambda: np.zeros(0))  # Hz
    bounds: Array = field(default_factory=lambda: np.zeros(0))  # of mu there, from above
    of_each: Array = field(default_factory=lambda: np.zeros((0, 0)))  # |S_ii - 1/2|, one a loop
    # the largest |S_ij| over all frequencies, S = (I + L)^-1, from wire j to wire i; and the same of T = I - S
    sensitivities: Array = field(default_factory=lambda: np.zeros((0, 0)))
    complementary: Array = field(default_factory=lambda: np.zeros((0, 0)))
    notes: tuple[str, ...] = ()
    tick: int = 0  # of the operating point
    time: float = 0.0  # s
    told: str = ""  # how it was found

    @property
    def gain(self) -> float | None:
        """Factor by which all gains may rise or fall at once, each on its own; infinite from a margin of 2 on."""
        if self.margin is None:
            return None
        return math.inf if self.margin >= 2.0 else (2.0 + self.margin) / (2.0 - self.margin)

    @property
    def phase(self) -> float | None:
        """Phase in rad by which all wires may turn at once, each in its own direction."""
        return None if self.margin is None else 2.0 * math.atan(0.5 * self.margin)

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        gain = self.gain
        return {
            "loops": dict(zip(self.loops, self.open_at, strict=True)),
            "verdict": self.verdict,
            "operating_point": {"tick": self.tick, "time_s": self.time, "found": self.told},
            "disk_margin": self.margin,
            "unstable_at": self.reached,
            "frequency_hz": self.frequency,
            "critical_factors": [[f.real, f.imag] for f in self.factors],
            "gain_db": None if gain is None or math.isinf(gain) else 20.0 * math.log10(gain),
            "phase_deg": None if self.phase is None else math.degrees(self.phase),
            "disk_margin_alone": dict(zip(self.loops, self.alone, strict=True)),
            "disk_margin_unstructured": self.unstructured,
            "sensitivity_peaks": self.sensitivities.tolist(),
            "complementary_peaks": self.complementary.tolist(),
            "notes": list(self.notes),
        }


def margins_together(graph: GraphSource, loops: Sequence[str] = (), *, at: At = AUTO) -> Together:
    """Return the disk margin for simultaneous perturbations of several loops: those named, or all of the graph.

    A loop is named as in the graph, or by the output at which it is opened. Raises `ModelError`
    where a loop cannot be told or linearised.

    `graph` has the `loops`. The operating point `at` is that of `margins`.

    >>> from proofmass import margins_together, read_graph
    >>> graph = read_graph("library:closed_loop_accelerometer")
    >>> together = margins_together(graph, ["dac.voltage", "adc.number"])
    >>> together.verdict, round(together.margin, 3), [round(margin, 3) for margin in together.alone]
    ('stable', 0.788, [1.538, 1.538])
    """
    planned = plan(graph)
    named = dict(one_loop(planned, loop) for loop in loops) if loops else loop_nodes(planned)
    group, nodes = _group(planned, named), tuple(named.values())

    def joint(about: Linearisation, alone: Sequence[OpenLoop]) -> OpenLoop:
        if group is not None:
            return about.analog_loop(group, nodes)
        ticks = round(max(one.map.period for one in alone) / planned.period)
        if problems := _too_many(planned, nodes, ticks):
            raise ModelError([planned.graph.placed(problem) for problem in problems])
        return _opened(about, nodes)

    points = OperatingPoints(planned, at)
    about, (*alone, system) = points.about_loops(nodes, otherwise=loop_through_bits, joint=joint)
    starting = (one for one in alone if one.map.starting)
    told = dict.fromkeys(note for one in (system, *starting) for note in one.map.notes)
    corners = () if group else about.corner_notes(Ends(nodes, nodes, cut=True))
    sizes = [sum(entry[:2] == node for entry in system.map.inputs) for node in nodes]
    found = of_system(system, list(named), sizes, [".".join(node) for node in nodes], (*told, *corners))
    return replace(found, tick=system.map.tick, time=system.map.time, told=about.told)


def _opened(about: Linearisation, nodes: tuple[Endpoint, ...]) -> OpenLoop:
    """Return loops opened at some wires at once, through quantisers of one bit where one has no other way."""
    try:
        for node in nodes:
            about.loop(node)
    except ModelError:
        through = loop_through_bits(about, *nodes)
        if through is None:
            raise
        return through
    return of_wires(about.map(nodes, nodes, cut=True), about.plan.period)


def _too_many(planned: Plan, nodes: Sequence[Endpoint], ticks: int) -> list[Problem]:
    """Return the problem of wires with too many values in some base ticks, if there is one."""
    values = sum(ticks // planned.stride(node) for node in nodes)
    expected, hint = f"at most {MOST_VALUES}", "name fewer with --loop, or open them at their slowest wires"
    few = values <= MOST_VALUES
    return [] if few else [Problem(message=_TOO_MANY, key="loops", got=f"{values:,}", expected=expected, hint=hint)]


def of_system(
    system: OpenLoop,
    loops: Sequence[str],
    sizes: Sequence[int],
    open_at: Sequence[str] = (),
    notes: tuple[str, ...] = (),
) -> Together:
    """Return the margin of an open loop of several wires, with some values of each in a period."""
    system, verdict, _, hidden = seen(system)
    notes = (*notes, *(f"without {mode}" for mode in hidden))
    base = Together(loops=tuple(loops), open_at=tuple(open_at or loops), verdict=verdict, notes=notes)
    return base if verdict != "stable" else _measured(base, system, sizes)


def _group(planned: Plan, loops: dict[str, Endpoint]) -> Group | None:
    """Return the continuous blocks between which all loops are opened, None of sampled ones; raises `ModelError`.

    Loops with more values in a period than can be followed are refused too.
    """
    problems = []
    if len(loops) < 2:
        hint = "name two or more with --loop, or in [loops]; proofmass margins is for one"
        problems.append(Problem(message="perturbations together need several loops", key="loops", hint=hint))
    if len(set(loops.values())) < len(loops):
        problems.append(Problem(message="two loops are opened at the same output", key="loops"))
    groups = {name: analog_group(planned, node) for name, node in loops.items()}
    first = next(iter(groups.values()), None)
    for name, group in groups.items():
        if group is not first:
            problems.append(_apart(loops, name, next(iter(loops)), group))
    nodes = tuple(loops.values())
    period = Ends(nodes, nodes, cut=True).common_period(planned)
    problems += _too_many(planned, nodes, period) if first is None else []
    if problems:
        raise ModelError([planned.graph.placed(problem) for problem in problems])
    return first


def _apart(loops: dict[str, Endpoint], name: str, first: str, group: Group | None) -> Problem:
    where = "between continuous blocks of its own" if group is not None else "where signals are sampled"
    return Problem(
        message=f"loop {name} is opened {where}, loop {first} is not",
        key=".".join(loops[name]),
        expected="loops that are all sampled, or all between the same continuous blocks",
        hint="open all of them at sampled or held outputs",
        path=("blocks", loops[name][0]),
    )


def _measured(base: Together, system: OpenLoop, sizes: Sequence[int]) -> Together:
    w = sweep(system)
    if not system.continuous:
        w = np.append(w, math.pi / system.map.period)
        w = np.unique(w[w <= math.pi / system.map.period * (1.0 + 1e-12)])
    matrices = _disks(system, w)
    quick = np.array([_balanced(matrix, sizes) for matrix in matrices])
    best, place, exact = 0.0, w[0], dict[int, float]()
    for i in np.argsort(-quick).tolist():  # the quick bound is above mu, and may peak elsewhere
        if quick[i] <= best:
            break
        exact[i] = upper_bound(matrices[i], sizes, None, _CLOSE).bound
        if exact[i] > best:
            best, place = exact[i], w[i]
    for i in sorted(exact, key=lambda i: -exact[i])[:_PEAKS]:
        at, value = _refined(system, sizes, w[max(i - 1, 0)], w[i], w[min(i + 1, len(w) - 1)])
        if value > best:
            best, place = value, at
    critical = _disks(system, np.array([place]))[0]
    upper = upper_bound(critical, sizes).bound
    low, turn = lower_bound(critical, sizes)
    values = np.linalg.eigvals(np.repeat(turn, sizes)[:, None] * critical)
    turn = turn * np.exp(-1j * np.angle(values[int(np.argmax(np.abs(values)))]))
    deltas = turn / low if low else turn
    with np.errstate(divide="ignore"):
        factors = (1.0 + deltas / 2.0) / (1.0 - deltas / 2.0)
    ends = np.cumsum([0, *sizes])
    blocks = list(pairwise(ends.tolist()))
    gains = np.array([[np.linalg.norm(m[a:b, a:b], 2) for m in matrices] for a, b in blocks])
    alone = tuple(1.0 / _peak_of(system, w, 0.0, (a, b), (a, b)) for a, b in blocks)
    peaks_of = {
        shift: np.array([[_peak_of(system, w, shift, rows, columns) for columns in blocks] for rows in blocks])
        for shift in (0.5, -0.5)
    }
    return replace(
        base,
        margin=1.0 / upper,
        reached=1.0 / low if low else None,
        frequency=float(place) / (2.0 * math.pi),
        factors=tuple(map(complex, factors)) if np.max(np.abs(factors)) < _WITHOUT_LIMIT else (),
        alone=alone,
        unstructured=1.0 / max(float(np.linalg.norm(matrix, 2)) for matrix in [*matrices, critical]),
        frequencies=w / (2.0 * math.pi),
        bounds=quick,
        of_each=gains,
        sensitivities=peaks_of[0.5],
        complementary=peaks_of[-0.5],
    )


def _disks(system: OpenLoop, w: Array) -> Complex:
    """S - I / 2 at some frequencies, by the closed loop."""
    closed = system.complementary(w)
    return np.asarray(0.5 * np.eye(closed.shape[-1]) - closed)


def _balanced(matrix: Complex, sizes: Sequence[int]) -> float:
    """Return a quick upper bound: by scales that make norms of rows and columns alike (Osborne)."""
    ends = np.cumsum([0, *sizes])
    blocks = list(pairwise(ends.tolist()))
    norms = np.array([[np.linalg.norm(matrix[a:b, c:d]) for c, d in blocks] for a, b in blocks])
    np.fill_diagonal(norms, 0.0)
    scales = np.ones(len(sizes))
    for _ in range(_BALANCES):
        for i in range(len(sizes)):
            row, column = float(np.linalg.norm(norms[i] / scales)), float(np.linalg.norm(norms[:, i] * scales))
            if row > 0.0 or column > 0.0:  # loops that only one way goes between come nearly apart
                scales[i] = math.sqrt(max(column, _ONE_WAY * row) / max(row, _ONE_WAY * column))
    factors = np.repeat(scales, sizes)
    return float(np.linalg.norm(factors[:, None] * matrix / factors, 2))


def _refined(system: OpenLoop, sizes: Sequence[int], low: float, middle: float, high: float) -> tuple[float, float]:
    """Return the frequency and value of the peak of mu between frequencies, by golden section."""
    scales: Any = None

    def value(w: float) -> float:
        nonlocal scales
        found = upper_bound(_disks(system, np.array([w]))[0], sizes, scales, _CLOSE)
        scales = found.scales
        return found.bound

    return _golden(value, low, high, (middle, value(middle)))


def _peak_of(system: OpenLoop, w: Array, shift: float, rows: tuple[int, int], columns: tuple[int, int]) -> float:
    """Return the peak of a block of S - I/2 + shift I: of S for 1/2, of -T for -1/2."""
    (a, b), (c, d) = rows, columns

    def values(at: Array) -> Array:
        matrices = _disks(system, at) + shift * np.eye(len(system.matrices[3]))
        return np.asarray(np.linalg.norm(matrices[:, a:b, c:d], 2, axis=(1, 2)))

    every = values(w)
    i = int(np.argmax(every))
    ends = float(w[max(i - 1, 0)]), float(w[min(i + 1, len(w) - 1)])
    return _golden(lambda at: float(values(np.array([at]))[0]), *ends, (float(w[i]), float(every[i])))[1]


def _golden(value: Any, low: float, high: float, best: tuple[float, float]) -> tuple[float, float]:
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_left, at_right = value(left), value(right)
    for _ in range(_REFINED):
        best = max(best, (left, at_left), (right, at_right), key=lambda pair: pair[1])
        if high - low <= _NARROW * high:
            break
        if at_left > at_right:
            high, right, at_right = right, left, at_left
            left = high - _GOLDEN * (high - low)
            at_left = value(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + _GOLDEN * (high - low)
            at_right = value(right)
    return best
