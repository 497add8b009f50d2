"""Notes on a study: of its ages, correlations and limits, and of what its loops are linearised about."""

from collections.abc import Iterator

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.studies.ages import DAY, age_text, written_age
from proofmass.graphs.studies.study import Study
from proofmass.runner.studies.runs.margins_per_run import notes_on_margins


def notes_of_a_study(study: Study) -> list[Problem]:
    """Return the notes on a study, and on blocks at a corner about which its loops are linearised."""
    return [*study_notes(study), *notes_on_margins(study.graph, study.margins)]


def study_notes(study: Study) -> Iterator[Problem]:
    """Yield notes on the ages, correlations and limits of a study."""
    if 0.0 < study.epochs[-1] < DAY:
        message = f"the last age is {age_text(study.epochs[-1])}"
        hint = 'ages without a unit are seconds: write "10 year", "1000 h"'
        yield study.placed(Problem(message=message, hint=hint, note=True, path=("epochs",)))
    yield from _turned_correlations(study)
    if not study.recalibration.carried or len(study.epochs) < 2:
        return
    message = "counts the first epoch too, which has no calibration before it"
    hint = f'from = "{written_age(study.epochs[1])}" counts from the next epoch on'
    for name, limit in study.limits.items():
        if name in study.flat.measures and limit.counted(study.epochs) == 0:
            yield study.placed(Problem(message=message, hint=hint, note=True, path=("limits", name)))


def _turned_correlations(study: Study) -> Iterator[Problem]:
    """Yield pairs of which one alone falls as its deviate rises: the values have the opposite correlation."""

    def falls(name: str) -> bool:
        spread = study.spread[name]
        return (spread.relative or spread.shape == "lognormal") and study.nominal(name) < 0.0

    for first, second, coefficient in study.correlation.pairs:
        if coefficient and falls(first) != falls(second):
            names = " and ".join(map(study.name_of, (first, second)))
            message = f"{names}: a relative spread about a value below zero turns the sign of their correlation"
            got = f"{coefficient:g} of the deviates, so about {-coefficient:g} of the values"
            hint = f"write {-coefficient:g} if the values are meant"
            yield study.placed(Problem(message=message, got=got, hint=hint, note=True, path=("correlation",)))
