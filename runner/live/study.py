"""A study that runs in the background of a live page: every second the page is told how its measures stand."""

import math
import tempfile
import threading
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.studies.study import Study
from proofmass.runner.live.long_run import Tell
from proofmass.runner.live.model import scales_of
from proofmass.runner.live.session import Background
from proofmass.runner.run.faults import RunError
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.whole.study import run_study

_FIRST = 20  # runs before the first histogram
_MOST = 5000  # values of a histogram


def live_study(path: Path, read: Callable[[], Study]) -> Background:
    """Return what runs the study of a file, more and more of it, until it is done or stopped."""

    def background(tell: Tell, stop: threading.Event) -> None:
        try:
            study = read()
            with tempfile.TemporaryDirectory() as folder:
                runs = min(_FIRST, study.runs)
                while not stop.is_set():
                    own = str(runs) if study.design == "latin_hypercube" else ""  # more sensors are all others
                    result = run_study(study, runs=runs, folder=Path(folder, own), threads=1)
                    tell(_message(path, result, study.runs))
                    if runs >= study.runs or result.interrupted:
                        return
                    runs = min(study.runs, max(runs + 1, int(runs * min(2.0, 1.0 + 1.0 / max(result.seconds, 0.1)))))
        except ModelError as error:
            tell({"problems": [problem.as_data() for problem in error.problems]})
        except (RunError, OSError) as error:
            tell({"problems": [Problem(message=str(error), file=str(path)).as_data()]})

    return background


def has_study(path: Path) -> bool:
    """Return whether a graph file has a study of its own."""
    try:
        return "study" in tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return False


def _message(path: Path, result: StudyResult, runs: int) -> dict[str, Any]:
    """Last values of each sensor by measure, with units and limits, for the page."""
    result = as_shown(result)
    values = {name: [float(value) for value in rows[-_MOST:, -1]] for name, rows in result.values.items()}
    ends = {name: (limit.at_least, limit.at_most) for name, limit in result.study.limits.items()}
    limits = {name: [end if math.isfinite(end) else None for end in pair] for name, pair in ends.items()}
    return {
        "name": path.name,
        "done": len(result.numbers),
        "runs": runs * result.study.points,
        "values": {name: [value for value in column if value == value] for name, column in values.items()},
        "units": {measure.name: scales_of(measure.unit) for measure in result.measures},
        "limits": limits,
    }
