"""How often the intervals of a study hold the truth: `python -m benchmarks.coverage [SEEDS]`.

For each interval, law and number of sensors, the part of the seeds whose interval of 95 % holds the true value. What is
more than two points under its name is marked, after two standard errors of the number of seeds. Student's interval of a
mean is that of normal measures; of others it claims nothing below 30 sensors, and stands in brackets.
"""

import math
import sys
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from proofmass.runner.comparison.studies import _independent
from proofmass.runner.studies.outcome.intervals import (
    LEVEL,
    Bounds,
    deviation_interval,
    mean_interval,
    part_interval,
    percentile_interval,
)

SENSORS = (2, 3, 5, 8, 10, 30, 100, 1000)
LAWS: dict[str, Any] = {
    "normal": stats.norm(),
    "uniform": stats.uniform(),
    "lognormal 0.1": stats.lognorm(0.1),
    "lognormal 0.5": stats.lognorm(0.5),
    "exponential": stats.expon(),
}
YIELDS = (0.5, 0.8, 0.95, 0.985, 0.999)
POINTS = 20
UNDER = 0.02
FEWEST_OF_MEANS = 30


class Case(NamedTuple):
    """An interval of samples of a law, and the value that it should hold."""

    name: str
    law: str
    draw: Callable[[np.random.Generator, int], Any]
    interval: Callable[[Any], Bounds]
    truth: float
    fewest: int = 2  # sensors for which it claims to hold


def cases() -> Iterator[Case]:
    """Yield every interval that studies print, for each law."""
    for name, law in LAWS.items():

        def sample(dice: np.random.Generator, sensors: int, law: Any = law) -> Any:
            return law.rvs(sensors, random_state=dice)

        def both(dice: np.random.Generator, sensors: int, law: Any = law) -> Any:
            return law.rvs((2, sensors), random_state=dice)

        yield Case("mean", name, sample, mean_interval, law.mean(), 2 if name == "normal" else FEWEST_OF_MEANS)
        yield Case("std", name, sample, deviation_interval, law.std())
        for percent in (1.0, 50.0, 99.0):
            yield Case(
                f"p{percent:g}", name, sample, lambda v, p=percent: percentile_interval(v, p), law.ppf(percent / 100.0)
            )
        yield Case("difference, paired", name, both, lambda v: mean_interval(v[1] - 0.5 * v[0]), 0.5 * law.mean())
        yield Case("difference, others", name, both, lambda v: _independent(v[0], v[1])[0], 0.0)
    for part in YIELDS:

        def good(dice: np.random.Generator, sensors: int, part: float = part) -> Any:
            return dice.random(sensors) < part

        yield Case("yield", f"{100 * part:g} %", good, lambda v: part_interval(float(v.sum()), len(v)), part)
        yield Case("yield of points", f"{100 * part:g} %", _points(part), _of_points, part)


def _points(part: float) -> Callable[[np.random.Generator, int], Any]:
    """Sensors at points that have half of their variance in common."""
    limit = stats.norm.ppf(part)

    def draw(dice: np.random.Generator, sensors: int) -> Any:
        return math.sqrt(0.5) * (dice.normal(size=(sensors, 1)) + dice.normal(size=(sensors, POINTS))) < limit

    return draw


def _of_points(good: Any) -> Bounds:
    return part_interval(float(good.mean()) * len(good), len(good))


def coverage(case: Case, sensors: int, seeds: int) -> float:
    """Return the part of the seeds for which the interval holds the truth."""
    held = 0
    for seed in range(seeds):
        low, high = case.interval(case.draw(np.random.default_rng([seed, sensors]), sensors))
        held += low <= case.truth <= high
    return held / seeds


def _text(part: float, least: float, counts: bool) -> str:
    return f"{100 * part:7.1f}{'!' if part < least else ' '}" if counts else f"{f'({100 * part:.1f})':>8}"


def main(seeds: int) -> int:
    """Print the table, and return how many of its entries are too low."""
    least = LEVEL - UNDER - 2.0 * math.sqrt(LEVEL * (1.0 - LEVEL) / seeds)
    print(f"{'interval':20}{'of':16}" + "".join(f"{sensors:8}" for sensors in SENSORS))
    low = 0
    for case in cases():
        parts = [coverage(case, sensors, seeds) for sensors in SENSORS]
        claimed = [sensors >= case.fewest for sensors in SENSORS]
        low += sum(part < least for part, counts in zip(parts, claimed, strict=True) if counts)
        texts = (_text(part, least, counts) for part, counts in zip(parts, claimed, strict=True))
        print(f"{case.name:20}{case.law:16}" + "".join(texts))
    print(f"{low} below {100 * least:.1f} %, of {seeds:,} seeds")
    return low


if __name__ == "__main__":
    sys.exit(bool(main(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)))
