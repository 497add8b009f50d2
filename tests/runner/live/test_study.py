"""A study that runs in the background of a page: what the page is told, beside the same study alone."""

import threading
from pathlib import Path
from typing import Any

import pytest

from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.live.study import live_study
from proofmass.runner.studies.whole.study import run_study

TEXT = """
name = "a constant"
rate = "1 kHz"
samples = 1
measures = { m = { signal = "a.output", statistic = "last" } }
blocks = { a = { kind = "Constant", value = 1 } }
[study]
runs = 30
design = "%s"
spread = { "a.value" = { uniform = 0.5 } }
"""


@pytest.mark.defect("C883", before="a Latin hypercube ended after 20 runs: belongs to another study", after="runs")
@pytest.mark.parametrize("design", ["random", "latin_hypercube"])
def test_a_page_is_told_all_sensors(design: str) -> None:
    study, told = read_study_text(TEXT % design), list[dict[str, Any]]()
    live_study(Path("study.toml"), lambda: study)(told.append, threading.Event())
    assert [message.get("done") for message in told] == [20, 30]
    assert told[-1]["values"]["m"] == run_study(study)["m"][:, 0].tolist()
