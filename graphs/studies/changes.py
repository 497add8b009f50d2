"""Changes of measures along the epochs of a study: measures of their own, for tables, limits and influences.

A change at an epoch e is m(e) - m(r), or relative to m(r). The reference r is the first epoch of an
age, or a run that follows the last calibration before e at once, with what it left and noise of its
own: what the sensor read when it had just been calibrated.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.graphs.model.keys import CHANGE_KEYS
from proofmass.graphs.studies.ages import age_text
from proofmass.graphs.studies.table_entries import checked_table, read_flag, read_time

CALIBRATION = "calibration"
CHANGE_EXAMPLE = 'write { measure = "bias", since = "calibration" }'


class Change(NamedTuple):
    """The change of a measure since an age in seconds, or since the last calibration (None)."""

    measure: str
    since: float | None
    relative: bool

    @property
    def since_calibration(self) -> bool:
        """Return whether the reference is the last calibration."""
        return self.since is None

    @property
    def text(self) -> str:
        """Return what it is since, in words."""
        return f"change since {'the last calibration' if self.since is None else age_text(self.since)}"

    def reference(self, ages: Sequence[float]) -> int:
        """Return the epoch of the reference; the first where it is the last calibration."""
        return next((epoch for epoch, age in enumerate(ages) if self.since is not None and age >= self.since), 0)


def read_change(given: object, units: Mapping[str, str], ages: Sequence[float], calibrated: bool) -> Change:
    """Return an entry of `[changes]`, of measures with these units; raises `Refusal`."""
    table = checked_table(given, CHANGE_KEYS, CHANGE_EXAMPLE)
    measure, since = table.get("measure"), table.get("since", 0)
    if not isinstance(measure, str) or measure not in units:
        raise Refusal("must name a measure", key="measure", got=shown(measure), expected=", ".join(units))
    relative = read_flag(table, "relative")
    if since == CALIBRATION:
        if not calibrated:
            hint = 'add [study.recalibration], or write since = "0 h"'
            raise Refusal("the study calibrates nothing", hint, key="since", got=shown(since))
        return Change(measure, None, relative)
    age = float(read_time(since, "since", f'an age, or "{CALIBRATION}"'))
    same = next((epoch for epoch in ages if math.isclose(age, epoch, rel_tol=1e-9)), None)
    if age and same is None:
        raise _no_epoch(since, age, ages)
    return Change(measure, same or 0.0, relative)


def _no_epoch(since: object, age: float, ages: Sequence[float]) -> Refusal:
    if age > ages[-1]:
        return Refusal("no epoch is so old", key="since", got=shown(since), expected=f"at most {age_text(ages[-1])}")
    later = next(number for number, epoch in enumerate(ages) if epoch > age)
    near = " or ".join(age_text(epoch) for epoch in ages[max(later - 1, 0) : later + 1])
    hint = "add it to the ages, or take one of them"
    return Refusal("no epoch is at this age", hint, key="since", got=shown(since), expected=near)
