"""Changes of measures along the epochs of a study: measures of their own, for tables, limits and influences.

A change at an epoch e is m(e) - m(r), or relative to m(r). The reference r is the first epoch of an age, or a run that
follows the last calibration before e at once, with what it left and noise of its own: what the sensor read when it had
just been calibrated.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from proofmass.blocks.declaration.problem import Refusal, shown
from proofmass.graphs.model.keys import CHANGE_KEYS
from proofmass.graphs.model.rates import read_duration
from proofmass.graphs.studies.ages import age_text
from proofmass.graphs.studies.table_entries import checked_table, read_flag

CALIBRATION = "calibration"
CHANGE_EXAMPLE = 'write { measure = "bias", since = "calibration" }'


class Change(NamedTuple):
    """The change of a measure since an age in seconds, or since the last calibration (None)."""

    measure: str
    since: float | None = 0.0
    relative: bool = False

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
    try:
        age = float(read_duration(since))
    except Refusal as error:
        raise error.under("since", since, f'an age, or "{CALIBRATION}"') from None
    if age > ages[-1]:
        raise Refusal("no epoch is so old", key="since", got=shown(since), expected=f"at most {age_text(ages[-1])}")
    return Change(measure, age, relative)
