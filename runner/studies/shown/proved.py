"""Proved bounds of margins in the report of a study, beside the runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from proofmass.runner.output.page import table
from proofmass.runner.studies.outcome.result import StudyResult


@dataclass(frozen=True)
class ProvedBound:
    """A margin that all sensors of a box have at least."""

    measure: str  # of the study, as "main.gain_margin"; "" if it has no such measure
    claim: str  # in words, with its loop
    limit: float  # in the unit of the measure
    box: str  # the tolerances, in words
    beyond: tuple[str, ...]  # what the study varies further than the box


def bounds_of(bounds: Sequence[ProvedBound], measure: str) -> list[float]:
    """Return the bounds of a measure."""
    return [bound.limit for bound in bounds if bound.measure == measure]


def proved_section(result: StudyResult, bounds: Sequence[ProvedBound]) -> str:
    """Return a table of what is proved for every sensor of a box, and the least among the runs of the study."""
    units = {measure.name: measure.unit for measure in result.measures}
    rows = [(one.claim, one.box, _least(result, one.measure, units), _spread(one.beyond)) for one in bounds]
    about = (
        "<p>For every sensor within the tolerances, not only for those that were run. The certificate is verified.</p>"
    )
    return about + table(("proved", "within", "least of the runs", "spread of the study"), rows, numbers=(2,))


def _least(result: StudyResult, measure: str, units: Mapping[str, str]) -> str:
    values = result[measure] if measure else np.array([])
    unit = "" if units.get(measure, "1") == "1" else f" {units[measure]}"
    return f"{np.nanmin(values):.4g}{unit}" if np.isfinite(values).any() else ""


def _spread(beyond: Sequence[str]) -> str:
    return f"goes beyond: {', '.join(beyond)}" if beyond else "lies within"
