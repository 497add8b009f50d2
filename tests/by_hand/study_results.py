"""Results of studies made by hand, for the tests of what is said, drawn and written of them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.result import StudyResult
from tests.by_hand.study_texts import STUDY

HEAD = STUDY.partition("[study]")[0] + "[study]\nseed = 11\n"
SWEPT = 'sweep = { "filter.corner_frequency" = ["100 Hz", "200 Hz"] }\n'
AGED = 'epochs = { ages = ["0 h", "1 year", "3 year"] }\n'
LIMITED = "limits = { bias = { at_least = -2, at_most = 3 }, noise = { at_most = 8 } }\n"


def measure(name: str, unit: str = "1", shown_in: str = "") -> PlannedMeasure:
    """A mean of a code."""
    return PlannedMeasure(name, "adc.code", "mean", unit, ("adc", "code"), False, 0, shown_in)


def study_result(
    tables: str, values: Mapping[str, ArrayLike], units: Mapping[str, str] | None = None, **changes: Any
) -> StudyResult:
    """A finished result of the converter that ages: keys of its study, and rows of its measures by run and epoch."""
    rows = {name: np.array(column, dtype=float) for name, column in values.items()}
    runs, study = len(next(iter(rows.values()))), read_study_text(HEAD + tables)
    study = study.changed(runs=-(-runs // study.points), seed=11)
    measures = tuple(measure(name, (units or {}).get(name, "1")) for name in rows)
    facts: dict[str, Any] = {
        "study": study,
        "measures": measures,
        "numbers": np.arange(runs),
        "values": rows,
        "faults": {},
        "planned_runs": runs,
        "seconds": 1.5,
        "engine": "python",
        "provenance": {"graph_hash": "0123abcd", "proofmass": "0.1.0", "date": "2026-01-02"},
    }
    return StudyResult(**facts | changes)
