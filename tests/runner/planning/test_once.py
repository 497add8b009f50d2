"""A plan reads, flattens and schedules a graph once: what is known is not worked out again."""

from collections import Counter
from typing import Any

import pytest

from proofmass.graphs.checks import check as checks
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model import build, flatten, graph
from proofmass.runner.planning import plan as planning
from tests.by_hand.graph_texts import LIBRARY


@pytest.mark.parametrize("name", ["imu_3dof", "self_test_population"])
def test_a_plan_flattens_and_schedules_once_and_builds_no_graph(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    given = read_graph(next(path for path in LIBRARY if path.stem == name))
    calls = Counter[str]()

    def counted(where: Any, what: str) -> None:
        function = getattr(where, what)

        def count(*arguments: Any, **named: Any) -> Any:
            calls[what] += 1
            return function(*arguments, **named)

        monkeypatch.setattr(where, what, count)

    counted(graph.Graph, "__init__")
    counted(build.Graph, "__init__")
    counted(planning, "flatten")
    counted(checks, "flatten")
    counted(checks, "schedule")
    assert flatten.flatten is not planning.flatten
    planning.plan(given)
    assert calls == {"flatten": 1, "schedule": 1}


def test_what_a_file_says_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three axes of one file, with other parameters each, and moved into another folder: one reading of it."""
    read = Counter[str]()
    init = build.Graph.__init__

    def counted(self: Any, **values: Any) -> None:
        read[values["place"].file.rpartition("/")[2]] += 1
        init(self, **values)

    monkeypatch.setattr(build.Graph, "__init__", counted)
    read_graph(next(path for path in LIBRARY if path.stem == "imu_3dof"))
    assert read == {"imu_3dof.toml": 1, "self_calibrating_axis.toml": 1}
