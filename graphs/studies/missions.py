"""Mission profiles: temperatures that a sensor goes through again and again, for laws of ageing.

The history is a line through points of time and temperature, which may jump; after its last point
it begins anew. Over an age t it speeds ageing up by the integral of exp(E / k (1 / T0 - 1 / T))
(Arrhenius), and wears by its cycles of temperature, the sum of (range_i / reference)^m (Coffin and
Manson). Cycles are those of rainflow counting, simplified for repeating histories (ASTM E1049-85,
5.4.5); a part of a mission counts in proportion.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.blocks.noise_and_drift import arrhenius_ageing
from proofmass.graphs.model.keys import MISSION_KEYS, PHASE_KEYS
from proofmass.graphs.studies.empirical import read_columns
from proofmass.graphs.studies.table_entries import checked_table, read_quantity, read_time

MISSION_EXAMPLE = 'write phases = [{ temperature = "233 K", for = "8 h" }, { temperature = "358 K", for = "16 h" }]'
LEAST = 1.0  # kelvin
MOST_POINTS = 10_000
_FINEST = 2.0  # kelvin between the points of Simpson's rule


@dataclass(frozen=True)
class Mission:
    """Temperatures that repeat: times from 0 on in seconds, which may be equal, and kelvin."""

    times: tuple[float, ...]
    temperatures: tuple[float, ...]

    def __repr__(self) -> str:
        points = ", ".join(f"{time!r}: {kelvin!r}" for time, kelvin in zip(self.times, self.temperatures, strict=True))
        return f"Mission({points})"

    def exposure(self, age: float, law: arrhenius_ageing.Constants) -> float:
        """Return the seconds at the reference temperature that age a sensor as this age does."""
        whole, rest = divmod(age, self.times[-1])
        return whole * _exposure(self, law, self.times[-1]) + _exposure(self, law, rest)

    def wear(self, age: float, exponent: float, reference: float) -> float:
        """Return how many cycles of the reference range, in kelvin, wear as much as this age."""
        whole: float = sum((size / reference) ** exponent for size in cycles(self.temperatures))
        return whole * age / self.times[-1]


def cycles(temperatures: Sequence[float]) -> tuple[float, ...]:
    """Return the ranges of the closed cycles of a repeating history, by rainflow counting.

    >>> sorted(cycles([-2, 1, -3, 5, -1, 3, -4, 4]))
    [3, 4, 7, 9]
    """
    top = max(range(len(temperatures)), key=lambda place: temperatures[place])
    left, ranges = list[float](), list[float]()
    for value in (*temperatures[top:], *temperatures[: top + 1]):
        if len(left) > 1 and (left[-1] - left[-2]) * (value - left[-1]) >= 0.0:
            left.pop()  # no turning point
        elif left and value == left[-1]:
            continue
        left.append(value)
        while len(left) > 2 and abs(left[-1] - left[-2]) >= abs(left[-2] - left[-3]):
            ranges.append(abs(left[-2] - left[-3]))
            del left[-3:-1]
    return tuple(ranges)


@cache
def _exposure(mission: Mission, law: arrhenius_ageing.Constants, until: float) -> float:
    """Return the integral of the acceleration from the start of the history."""
    total = 0.0
    for (start, low), (end, high) in pairwise(zip(mission.times, mission.temperatures, strict=True)):
        span = min(end, until) - start
        if span <= 0.0:
            continue
        high = low + (high - low) * span / (end - start)
        pieces = max(1, math.ceil(abs(high - low) / _FINEST)) if high != low else 0
        if not pieces:
            total += span * arrhenius_ageing.acceleration_at(law, low)
        for piece in range(pieces):
            at = (low + (high - low) * (piece + part) / pieces for part in (0.0, 0.5, 1.0))
            first, middle, last = (arrhenius_ageing.acceleration_at(law, kelvin) for kelvin in at)
            total += span / pieces * (first + 4.0 * middle + last) / 6.0
    return total


def read_mission(given: object, folder: str) -> Mission:
    """Return an entry of `[missions]`; files are named from a folder. Raises `Refusal`."""
    table = checked_table(given, MISSION_KEYS, MISSION_EXAMPLE)
    ways = [way for way in ("phases", "points", "file") if way in table]
    if len(ways) != 1:
        raise Refusal("needs phases, points or a file", got=shown(dict(table)), hint=MISSION_EXAMPLE)
    times, temperatures = {"phases": _phases, "points": _points, "file": _file}[ways[0]](table, folder)
    if not 2 <= len(times) <= MOST_POINTS or times[0] != 0.0 or times[-1] <= 0.0 or sorted(times) != times:
        expected = f"times that ascend from 0, 2 to {MOST_POINTS:,} of them"
        raise Refusal("is not a history", key=ways[0], got=shown(times[:4]), expected=expected)
    if min(temperatures) < LEAST:
        raise Refusal("too cold", key=ways[0], got=f"{min(temperatures):g} K", expected=f"at least {LEAST:g} K")
    return Mission(tuple(times), tuple(temperatures))


def _phases(table: Mapping[str, Any], _folder: str) -> tuple[list[float], list[float]]:
    times, temperatures, now = list[float](), list[float](), 0.0
    phases = table["phases"]
    if not isinstance(phases, list | tuple) or not phases:
        raise Refusal("must be a list of phases", key="phases", got=shown(phases), hint=MISSION_EXAMPLE)
    for phase in phases:
        entry = checked_table(phase, PHASE_KEYS, MISSION_EXAMPLE)
        if set(entry) != set(PHASE_KEYS):
            raise Refusal("needs temperature and for", key="phases", got=shown(dict(entry)), hint=MISSION_EXAMPLE)
        kelvin = read_quantity(entry, "temperature", "K", LEAST)
        times += [now, now + float(read_time(entry["for"], "phases", "a time"))]
        temperatures += [kelvin, kelvin]
        now = times[-1]
    return times, temperatures


def _points(table: Mapping[str, Any], _folder: str) -> tuple[list[float], list[float]]:
    points = table["points"]
    if not isinstance(points, list | tuple) or not all(isinstance(p, list | tuple) and len(p) == 2 for p in points):
        hint = 'write points = [["0 h", "233 K"], ["8 h", "358 K"], ["24 h", "233 K"]]'
        raise Refusal("must be a list of times with temperatures", key="points", got=shown(points), hint=hint)
    times = [float(read_time(time, "points", "a time")) for time, _ in points]
    return times, [read_quantity({"points": kelvin}, "points", "K", LEAST) for _, kelvin in points]


def _file(table: Mapping[str, Any], folder: str) -> tuple[list[float], list[float]]:
    time, temperature = table.get("time", "time"), table.get("temperature", "temperature")
    if time == temperature:
        raise Refusal("time and temperature are one column", key="file", got=shown(dict(table)))
    times, temperatures = read_columns(table["file"], [(time, "s"), (temperature, "K")], folder)
    return [time - times[0] for time in times], temperatures
