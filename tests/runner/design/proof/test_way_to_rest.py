"""The way to a point of rest: it is followed from the sensor as it is, and ends when the time is up."""

import math

import numpy as np
import pytest

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.changes import with_parameters
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.derivatives.ball import UndecidedError, enclosing
from proofmass.runner.design.proof.prove import prove
from proofmass.runner.design.proof.rest_point import RestRun, _turned
from proofmass.runner.planning.plan import plan
from tests.by_hand.resting_loops import FRINGES, quadratic_loop
from tests.runner.design.proof.test_prove import status


@pytest.mark.defect(
    "S867",
    before='"stable" was refuted by a sensor that was taken at the other edge of its fringe',
    after="proved: a follower stays at its edge",
)
def test_a_sensor_stays_on_its_side_of_a_fringe() -> None:
    graph = read_graph_text(FRINGES)
    found = prove(graph, tolerances={"turn.value": [0.0, 6.5]}, at="settled")
    assert status(found) == ["proved"] * 3


@pytest.mark.parametrize("turn", [2.0, 3.0, 5.0, -4.0, -9.0])
def test_a_sensor_rests_where_it_is_led_by_its_parameters(turn: float) -> None:
    graph, node = read_graph_text(FRINGES), ("follower", "output")
    rest = RestRun(plan(graph), [node], Course(plan(graph)))
    there = rest.value(plan(with_parameters(graph, {"turn.value": turn})))
    assert there[0] == pytest.approx(turn + 0.5 * math.pi, abs=1e-12)


@pytest.mark.defect(
    "H874",
    before="a point of rest was looked for without a look at the clock: 18 minutes, where 20 s were asked for",
    after="the claim is open: the time is up",
)
def test_the_time_is_up_on_the_way_to_a_point_of_rest() -> None:
    loop, node = quadratic_loop(), ("plant", "output")
    rest, looks = RestRun(plan(loop), [node], Course(plan(loop))), iter([False] * 3)
    with enclosing():
        before = rest.enclosed({})
        with rest.until(lambda: next(looks, True)), pytest.raises(UndecidedError, match="the time is up in a period"):
            rest.enclosed({})
        assert rest.enclosed({}).as_data() == before.as_data()
    (stable, *others) = prove(loop, tolerances={"level.value": "10 %"}, at="settled", seconds=0.0).proofs
    assert stable.status == "open"
    assert stable.searched.why.startswith("the time is up")
    assert [one.searched.why for one in others] == [stable.searched.why] * 2


def test_a_loop_that_is_open_at_the_start_is_looked_at_where_it_rests() -> None:
    """A relay has no slope anywhere: both reasons are told, and at the start alone the one."""
    graph = read_graph_text("""
name = "relay"
rate = "1 kHz"
duration = "10 ms"
wires = ["sign.output -> integrator.input", "integrator.output -> minus.input", "minus.output -> sign.input"]
blocks.sign.kind = "Sign"
blocks.minus = { kind = "Gain", gain = -1.0 }
blocks.integrator = { kind = "DiscreteIntegrator", gain = "300 1/s", output_unit = "1" }
""")
    start, *rest = (
        prove(graph, "integrator.output", at=at).proofs[0].searched.why for at in ("0 s", "auto", "settled")
    )
    assert start == "what goes in at integrator.output does not come back at the start of the run"
    assert rest[0].startswith(f"{start}; ")
    assert rest[0].removeprefix(f"{start}; ") == rest[1]


@pytest.mark.parametrize(
    ("left", "turned"),
    [
        ([[2.0, 1.0], [0.0, -4.0]], 0.0),
        ([[1.0, 0.5], [0.0, -2.0]], 1.0),  # half of R: twice the slopes
        ([[-2.0, -1.0], [0.0, 4.0]], 2.0),
        ([[math.nan, 1.0], [0.0, -4.0]], math.inf),
        ([[0.0, 0.0], [0.0, 0.0]], math.inf),
    ],
)
def test_how_far_slopes_turn(left: list[list[float]], turned: float) -> None:
    assert _turned(np.array(left), np.array([[2.0, 1.0], [0.0, -4.0]])) == pytest.approx(turned, abs=1e-12)
