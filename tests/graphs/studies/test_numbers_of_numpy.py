"""Numbers and arrays of NumPy in the tables of studies and tunings: as if Python's stood there."""

from typing import Any

import numpy as np
import pytest

from proofmass import Graph, Study
from proofmass.blocks import Constant, Gain
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.tuning.build import tuning_of

FACTS: dict[str, Any] = {
    "name": "an amplifier",
    "rate": "1 kHz",
    "duration": "2 ms",
    "blocks": {"one": Constant(value=1.0), "first": Gain(gain=2.0), "second": Gain(gain=3.0)},
    "wires": ["one.output -> first.input", "first.output -> second.input"],
    "measures": {"last": {"signal": "second.output", "statistic": "last"}},
}
GRAPH = Graph(**FACTS)


def study(whole: Any, real: Any, listed: Any, true: Any) -> Study:
    """Return a study whose tables have numbers and lists as they are given."""
    return Study(
        graph=GRAPH,
        runs=whole(3),
        seed=whole(5),
        spread={"first.gain": {"values": listed([1.0, 2.0]), "weights": listed([1, 3])}},
        sweep={"one.value": listed([1.0, 2.0])},
        epochs={"ages": listed([0.0, 1e6])},
        drift={"second.gain": {"ramp": real(0.25), "relative": true}},
        limits={"last": {"at_least": real(0.5), "at_most": whole(9)}},
        stop={"last": real(0.5)},
    )


@pytest.mark.defect("H913", before="`must be an integer, got: np.int64(3)`, and so on", after="as Python's numbers")
def test_a_study_takes_numbers_of_numpy() -> None:
    plain = study(int, float, list, True)
    given = study(np.int64, np.float32, np.array, np.True_)
    assert given.text() == plain.text()
    assert (given.runs, given.seed, given.limits, given.stop) == (3, 5, plain.limits, plain.stop)
    assert type(given.runs) is int


@pytest.mark.defect("H915", before="`must be a number, got: np.float32(6.0)`, and so on", after="as Python's numbers")
def test_a_graph_takes_numbers_of_numpy() -> None:
    def made(whole: Any, real: Any) -> Graph:
        return Graph(
            **FACTS,
            loops={"main": {"open_at": "first.output", "gain_margin": real(6.0)}},
            requirements={"last": {"quantity": "last", "at_least": real(1.5), "at_most": whole(9)}},
            integration={"substeps": whole(2)},
        )

    assert write_graph(made(np.int64, np.float32)) == write_graph(made(int, float))


def test_a_tuning_takes_numbers_of_numpy() -> None:
    free = {"first.gain": {"at_least": np.int64(1), "at_most": np.float32(4.0)}}
    goals = {"last": {"measure": "last", "at_least": np.float32(7.5)}}
    tuning = tuning_of(GRAPH, free=free, goals=goals, samples=np.int64(4), starts=np.uint8(1), seed=np.int32(2))
    assert (tuning.free["first.gain"].at_least, tuning.goals["last"].at_least) == (1.0, 7.5)
    assert (tuning.samples, tuning.starts, tuning.seed) == (4, 1, 2)


@pytest.mark.parametrize("swept", [np.array([1j, 2.0]), np.ma.masked_array([1.0, 2.0], [False, True])])
def test_what_is_no_number_is_refused(swept: Any) -> None:
    with pytest.raises(ModelError, match="must be a number"):
        Study(graph=GRAPH, runs=3, sweep={"one.value": swept})


@pytest.mark.defect("H922", before="write  = [1.0, 2.0]", after="write a list, such as [1.0, 2.0]")
def test_the_hint_at_a_list_is_whole() -> None:
    with pytest.raises(ModelError) as caught:
        Study(graph=GRAPH, runs=3, sweep={"one.value": 2.0})
    assert caught.value.problems[0].hint == "write a list, such as [1.0, 2.0]"
