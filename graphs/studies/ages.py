"""Ages and intervals between calibrations in words."""

import math
from collections.abc import Sequence

SHOWN = 11  # ages in a table
HOUR, DAY, MONTH, YEAR = 3600.0, 86400.0, 2629800.0, 31557600.0  # seconds


def written_age(seconds: float) -> str:
    """Return an age as a study file has it, in the unit that suits it.

    >>> [written_age(age) for age in (0.0, 10.0, 3.6e6, MONTH, 3.0 * MONTH, 2.0 * YEAR)]
    ['0 h', '10 s', '1000 h', '1 month', '3 month', '2 year']
    """
    if seconds >= YEAR:
        return f"{seconds / YEAR:g} year"
    if 0.0 < seconds < HOUR:
        return f"{seconds:g} s"
    months = seconds / MONTH
    return f"{months:.0f} month" if months >= 1.0 and months == round(months) else f"{seconds / HOUR:g} h"


def age_text(seconds: float) -> str:
    """Return an age for a reader.

    >>> age_text(10.0), age_text(3.6e6), age_text(7889400.0), age_text(31557600.0), age_text(63115200.0)
    ('10 s', '1000 h', '3 months', '1 year', '2 years')
    """
    number, unit = written_age(seconds).split()
    return f"{number} {unit}" if unit in ("s", "h") or number == "1" else f"{number} {unit}s"


def some_of(ages: Sequence[float]) -> frozenset[float]:
    """Return at most a dozen of the ages at regular steps, the first and the last among them, for tables.

    >>> sorted(some_of([0.0, 1.0, 2.0])), len(some_of(range(121)))
    ([0.0, 1.0, 2.0], 11)
    """
    step = -(-(len(ages) - 1) // (SHOWN - 1)) or 1
    return frozenset({*ages[::step], ages[-1]})


def recalibration_text(seconds: float) -> str:
    """Return how often sensors are calibrated.

    >>> recalibration_text(31557600.0), recalibration_text(math.inf)
    ('recalibrated every year', 'never recalibrated')
    """
    return "never recalibrated" if seconds == math.inf else f"recalibrated every {age_text(seconds).removeprefix('1 ')}"
