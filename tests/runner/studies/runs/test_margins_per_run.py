"""Margins as measures of a study: those of each run's own parameters, limits on them, replay."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.loops import MARGIN_MEASURES, REQUIREMENTS
from proofmass.graphs.studies.build import Study
from proofmass.runner.analysis.margins.stability import margins, margins_or_reasons
from proofmass.runner.studies.whole.study import replay, run_study
from tests.by_hand.amounts import amounts

GAIN = 8000.0  # V/rad


@pytest.fixture(scope="module")
def graph() -> Graph:
    """The closed-loop accelerometer for two milliseconds, with a measure."""
    whole = read_graph(library_file("closed_loop_accelerometer.toml"))
    return Graph(
        name=whole.name,
        rate=whole.rate,
        samples=100,
        blocks=whole.blocks,
        wires=whole.wires,
        probes=["dac.code"],
        loops=whole.loops,
        measures={"code": {"signal": "dac.code", "statistic": "mean"}},
    )


@pytest.mark.exhaustive
def test_each_run_has_the_margins_of_its_parameters(graph: Graph) -> None:
    """Factors of 37.0 and 38.5 lie on both sides of the published limit."""
    factors = (1.0, 37.0, 38.5)
    limits = {"main.gain_margin": {"at_least": "6 dB"}, "main.phase_margin": {"at_least": "0.01 deg"}}
    study = Study(graph, runs=1, sweep={"pickoff.gain": [GAIN * f for f in factors]}, margins="0 s", limits=limits)
    result = run_study(study, engine="python")
    assert result["main.stable"][:, 0].tolist() == [1.0, 1.0, 0.0]
    for place, factor in enumerate(factors[:2]):
        expected = margins(graph.with_parameters({"pickoff.gain": GAIN * factor})).as_data()
        for name, unit in REQUIREMENTS.items():
            assert result[f"main.{name}"][place, 0] == pytest.approx(expected[f"{name}_{unit.lower()}"], rel=1e-11)
    assert all(math.isnan(result[f"main.{name}"][2, 0]) for name in ("gain_margin", "phase_margin", "delay_margin"))
    assert result.yields()["main.gain_margin"] == pytest.approx(1 / 3)
    assert result.yields()["main.phase_margin"] == pytest.approx(2 / 3)
    units = {measure.name: measure.unit for measure in result.measures}
    assert (units["main.gain_margin"], units["main.delay_margin"], units["main.stable"]) == ("dB", "s", "1")
    assert run_study(study, engine="compiled", lanes=4).digest == result.digest
    again = replay(study, 1, engine="python")
    assert again.measures["main.gain_margin"].value == result["main.gain_margin"][1, 0]


@pytest.mark.exhaustive
@pytest.mark.defect("F7", before="refused: no [measures]", after="the margins are measures enough")
def test_a_study_of_margins_alone(graph: Graph) -> None:
    bare = replace(graph, measures={})
    result = run_study(Study(bare, runs=1, margins="0 s"), engine="python")
    assert set(result.values) == {f"main.{name}" for name in MARGIN_MEASURES}
    assert result["main.stable"].tolist() == [[1.0]]
    assert (
        run_study(Study(bare, runs=3, margins="0 s"), engine="compiled", lanes=4)["main.stable"].tolist() == [[1.0]] * 3
    )
    with pytest.raises(ModelError, match="the graph has no measures"):
        Study(bare, runs=1)


@pytest.mark.exhaustive("stable")
@pytest.mark.parametrize(("verdict", "value"), [("stable", 1.0), ("marginal", 0.5), ("unstable", 0.0)])
def test_limits_say_which_verdicts_count(
    graph: Graph, verdict: str, value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def judged(points: Any, **_: Any) -> Any:
        return {name: replace(found, verdict=verdict) for name, found in margins_or_reasons(points).items()}  # type: ignore[type-var]

    monkeypatch.setattr("proofmass.runner.analysis.margins.many.margins_or_reasons", judged)
    monkeypatch.setattr("proofmass.runner.analysis.margins.many.ManyMargins._common", lambda self: [])
    kept = {}
    for least in ("unstable", "marginal", "stable"):
        study = Study(graph, runs=1, margins="0 s", limits={"main.stable": {"at_least": least}})
        result = run_study(study, engine="python")
        assert result["main.stable"].tolist() == [[value]]
        kept[least] = result.yields()["main.stable"]
    assert kept == {"unstable": 1.0, "marginal": float(value >= 0.5), "stable": float(value == 1.0)}


def test_a_verdict_that_there_is_not(graph: Graph) -> None:
    with pytest.raises(ModelError, match="there is no such verdict") as caught:
        Study(graph, margins="0 s", limits={"main.stable": {"at_least": "stabel"}})
    assert "'unstable', 'marginal', 'stable'" in caught.value.problems[0].expected


@pytest.mark.exhaustive
def test_a_ledger_keeps_a_run_without_margins(graph: Graph, tmp_path: Path) -> None:
    study = Study(graph, runs=1, sweep={"pickoff.gain": [GAIN, GAIN * 38.5]}, margins="0 s")
    first, second = (run_study(study, engine="python", folder=tmp_path) for _ in range(2))
    assert np.isnan(second["main.gain_margin"][1, 0])
    assert second.digest == first.digest
    assert not second.faults
    rows = [row for row in second.summary() if row["measure"] == "main.gain_margin"]
    assert [row["runs"] for row in rows] == [1]


@pytest.mark.parametrize("times", amounts(["0 s", 0.002], ["0 s", 0, "2 ms", 0.002]))
def test_the_operating_point_is_that_of_the_time(graph: Graph, times: list[Any]) -> None:
    """A push of 200 g saturates the converter after a while: the loop is open, and the run has failed."""
    pushed = graph.with_parameters({"acceleration.offset": 2000.0})
    for at in times:
        result = run_study(Study(pushed, runs=1, margins=at), engine="python")
        assert len(result.faults) == (at in ("2 ms", 0.002))
        assert all("does not come back" in text for text in result.faults.values())


def test_margins_want_a_loop_a_time_and_their_names(graph: Graph) -> None:
    loopless = replace(graph, loops={})
    for wanted, made, limits in (
        ("names no loops", loopless, {}),
        ('or "settled"', graph, {}),
        ("did you mean main.gain_margin?", graph, {"main.gain_margn": {"at_least": "6 dB"}}),
        ("not a ratio in decibels", graph, {"main.gain_margin": {"at_least": "6 V"}}),
    ):
        with pytest.raises(ModelError, match=wanted):
            Study(made, margins="soon" if "settled" in wanted else "0 s", limits=limits)
    with pytest.raises(ModelError, match="there is no such measure"):
        Study(graph, limits={"main.gain_margin": {"at_least": "6 dB"}})
