"""Changes as measures of a study: what each run has moved since an age, or since its last calibration."""

import numpy as np

from proofmass.graphs.studies.study import Study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.planned import PlannedMeasure


def change_measures(study: Study, measures: tuple[PlannedMeasure, ...]) -> tuple[PlannedMeasure, ...]:
    """Return the changes of measures that a study asks for, as measures that nothing reads in the loop."""
    units = {measure.name: (measure.unit, measure.shown_in) for measure in measures}
    found = []
    for name, change in study.changes.items():
        unit, shown_in = ("1", "") if change.relative else units[change.measure]
        found.append(PlannedMeasure(name, change.measure, change.text, unit, ("", ""), False, 0, shown_in))
    return tuple(found)


def change_values(study: Study, names: list[str], values: AnyArray, calibrated: AnyArray, after: AnyArray) -> AnyArray:
    """Return the changes of runs at all epochs, in the order of the study.

    `values` are by run, epoch and measure of `names`; `after` those of the runs that follow the calibrations, where
    `calibrated`, by run and epoch, says that one took place.
    """
    changed = np.empty((*values.shape[:2], len(study.changes)))
    for place, change in enumerate(study.changes.values()):
        column = names.index(change.measure)
        now = values[:, :, column]
        reference = np.repeat(now[:, change.reference(study.epochs)][:, None], now.shape[1], axis=1)
        if change.since_calibration:
            for epoch in range(1, now.shape[1]):
                before = slice(None), epoch - 1
                reference[:, epoch] = np.where(calibrated[before], after[(*before, column)], reference[before])
        with np.errstate(all="ignore"):
            changed[..., place] = (now - reference) / reference if change.relative else now - reference
    return changed
