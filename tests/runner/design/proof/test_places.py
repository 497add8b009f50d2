"""Places: a loop about a carrier whose phase nothing holds, curves with known slopes, and loops that are not stable."""

import math
import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest

from proofmass import margins, prove, read_study
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.rings import Rings
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.derivatives.ball import Ball, UndecidedError, enclosing
from proofmass.runner.derivatives.taylor_model import TaylorModel
from proofmass.runner.design.proof.closed_loop import OpenCorners
from proofmass.runner.design.proof.enclosed import Enclosed
from proofmass.runner.design.proof.places import Around, check_unseen, neutral, returned, tangents
from proofmass.runner.design.proof.prove import Proofs
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.plan.memory import Memory
from proofmass.runner.planning.plan import plan
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.runner.design.proof.test_prove import status

CARRIED = """
name = "a loop on a carrier"
rate = "16 kHz"
duration = "50 ms"
wires = [
    "controller.output -> sent.first",
    "carrier.leading_sine -> sent.second",
    "sent.output -> received.signal",
    "carrier.sine -> received.sine",
    "carrier.cosine -> received.cosine",
    "received.in_phase -> error.second",
    "level.output -> error.first",
    "error.output -> controller.input",
]

[loops.level]
open_at = "controller.output"

[blocks.level]
kind = "Constant"
value = 0.25

[blocks.carrier]
kind = "NumericallyControlledOscillator"
frequency = "1 kHz"
initial_phase = "0.3 rad"
lead = "60 deg"

[blocks.sent]
kind = "Product"

[blocks.received]
kind = "SynchronousDemodulator"
ratio = 16
unit = "1"

[blocks.error]
kind = "Difference"

[blocks.controller]
kind = "DiscreteIntegrator"
rate = "1 kHz"
gain = "400 1/s"
output_unit = "1"
"""
STEP = 0.4 * math.cos(math.radians(60.0))  # of the controller for an error of one: the carrier is ahead by 60 deg
LEAST = 20.0 * math.log10(
    2.0 * math.sin(math.pi / 6.0) / STEP
)  # z (z - 1) + K has poles on the circle at pi / 3 for K = 1


def on_carrier(**given: Any) -> Proofs:
    usual: dict[str, Any] = {"phase_margin": "30 deg", "seconds": 120.0, "workers": 1, "at": "settled"}
    return prove(read_graph_text(CARRIED), tolerances={"controller.gain": "5 %"}, **(usual | given))


@pytest.fixture(scope="module")
def rest() -> RestRun:
    planned = plan(read_graph_text(CARRIED))
    return RestRun(planned, [("controller", "output")], Course(planned))


@pytest.mark.exhaustive("0.11", "0.25", "0.49")
@pytest.mark.parametrize("place", [-0.5, -0.11, 0.25, 0.49])
def test_a_sensor_at_a_place(rest: RestRun, place: float) -> None:
    """K / (z (z - 1)) at a fixed carrier, whatever its phase, also where it has just turned."""
    node = ("controller", "output")
    assert [(one.name, one.low, one.high) for one in rest.ranges] == [("carrier:turns", -0.5, 0.5)]
    about = rest.linearised(plan(read_graph_text(CARRIED)), {"carrier:turns": place})
    figures: Any = margins_of(about.loop(node), "level", "controller.output")
    assert figures.least_gain_margin == pytest.approx(LEAST, abs=1e-9)


def test_what_proves_a_place_goes_from_process_to_process(rest: RestRun) -> None:
    with enclosing():
        point = rest.enclosed({})
    assert point.places
    sent = OpenCorners(0, 1, Enclosed.exact(np.zeros((1, 1))), None, point, (), 0).proving
    again = pickle.loads(pickle.dumps(sent))
    assert again.rest.as_data() == point.as_data()


@pytest.mark.exhaustive
def test_a_loop_about_each_phase_of_a_carrier() -> None:
    """The level is compared a period later: K / (z (z - 1)) at a fixed carrier, whatever its phase."""
    within = LEAST - 20.0 * math.log10(1.05)
    proved = on_carrier(gain_margin=f"{within - 0.05} dB")
    assert status(proved) == ["proved"] * 3
    (text,) = {line for line in proofs_text(proved).splitlines() if line.startswith("loop")}
    assert text == "loop level, opened at controller.output, at carrier:turns = -0.5 to 0.5"
    lines = check_certificate(certificate(proved))
    assert all("carrier:turns from -0.5 to 0.5" in line for line in lines)
    assert proved.proofs[0].as_data()["places"] == {"carrier:turns": (-0.5, 0.5)}


@pytest.mark.exhaustive
def test_beyond_the_margin_a_sensor_is_shown() -> None:
    found = on_carrier(gain_margin=f"{LEAST + 0.05} dB", phase_margin="1 deg")
    assert status(found) == ["proved", "refuted", "proved"]
    assert found.proofs[1].value == pytest.approx(LEAST, abs=1e-6)
    assert "see it by" in proofs_text(found)


def test_margins_say_the_same() -> None:
    figures: Any = margins(read_graph_text(CARRIED))
    assert figures.least_gain_margin == pytest.approx(LEAST, abs=1e-6)


HELD = """
name = "what is held for ever"
rate = "1 kHz"
duration = "0.1 s"
wires = ["push.output -> sum.first", "delay.output -> sum.second", "sum.output -> delay.input"]

[loops.held]
open_at = "delay.output"

[blocks.push]
kind = "Step"
offset = 1.0
amplitude = -1.0
start_time = "10 ms"

[blocks.sum]
kind = "Sum"

[blocks.delay]
kind = "UnitDelay"
"""


@pytest.mark.parametrize("at", ["auto", "settled", "0 s"])
def test_a_pole_at_one_that_a_loop_sees_is_its_own(at: str) -> None:
    """z^-1 in positive feedback keeps what it has: it is at no limit of stability that a proof may leave out."""
    assert "proved" not in status(prove(read_graph_text(HELD), at=at, seconds=20.0, workers=1))


def curves(poles: list[float], draw: np.random.Generator) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """A map with these poles and one of one, whose last state is the place, and how the others move with it."""
    n = len(poles)
    along = draw.normal(size=(n, 1))
    basis = np.block([[np.eye(n) + 0.1 * draw.normal(size=(n, n)), along], [draw.normal(size=(1, n)) * 0.1, np.eye(1)]])
    basis[:, n] = [*along[:, 0], 1.0]
    return basis @ np.diag([*poles, 1.0]) @ np.linalg.inv(basis), along


@pytest.mark.parametrize("seed", range(5))
def test_curves_and_what_is_left_of_a_map(seed: int) -> None:
    poles = [0.9, 0.5, -0.3, 0.0]
    a, along = curves(poles, np.random.default_rng(seed))
    chosen, known = neutral(a, [4])
    assert list(chosen) == [4]
    assert known == pytest.approx(along)
    start = known + 0.01
    left = np.linalg.inv(np.eye(4) - a[:4, :4] + along @ a[4:, :4])
    with enclosing():
        enclosed = tangents(TaylorModel.constant(a, 1e-12), start.tolist(), left)
        rows = returned(a.tolist(), 5, enclosed)
    assert all(
        Ball(row[0].arb).ends()[0] <= t <= Ball(row[0].arb).ends()[1]
        for row, t in zip(enclosed, along[:, 0], strict=True)
    )
    middle = np.array([[float(value.arb.mid()) for value in row] for row in rows])
    assert sorted(np.linalg.eigvals(middle).real) == pytest.approx(sorted(poles), abs=1e-8)


def test_a_place_moves_on_or_is_a_pole_of_its_own() -> None:
    """With a pole of 1.001 the last state is no place: whatever is left of the map, it grows."""
    along = np.array([[2.0]])
    basis = np.array([[1.0, 2.0], [0.1, 1.0]])
    a = basis @ np.diag([0.5, 1.001]) @ np.linalg.inv(basis)
    left = np.linalg.inv(np.eye(1) - a[:1, :1] + along @ a[1:, :1])
    with enclosing(), pytest.raises(UndecidedError, match="a pole of a place is not one"):
        tangents(TaylorModel.constant(a), along.tolist(), left)


def test_a_loop_that_sees_a_place() -> None:
    """x' = 0.5 x + u, p' = p + x, y = x + seen p: a factor at the wire moves the pole of one."""
    rows = [[0.5, 0.0, 1.0], [1.0, 1.0, 0.0], [0.1, 1e-3, 0.0]]
    with enclosing():
        check_unseen([*rows[:2], [0.1, 0.0, 0.0]], 2, [0, 1], [[0.0]])
        with pytest.raises(UndecidedError, match="the loop sees the place"):
            check_unseen(rows, 2, [0, 1], [[0.0]])


def fibre_optic() -> Graph:
    return read_study("library:fibre_optic_gyroscope").graph


@pytest.mark.exhaustive
def test_a_ramp_that_falls_is_no_place_while_its_step_is_learnt() -> None:
    graph = fibre_optic()
    with pytest.raises(ModelError, match="ramp:total moves on, and what is remembered follows it") as caught:
        RestRun(plan(graph), [("slope", "output")], Course(plan(graph)))
    assert caught.value.problems[0].hint == 'hold what learns slowly: --constant "trim.output=VALUE"'


@pytest.mark.exhaustive
def test_the_fibre_optic_gyroscope_between_falls_of_its_ramp() -> None:
    """Its rate loop has the margins that are found at the same trim, with a gain and a rotation that vary."""
    tolerances = {"amplifier.gain": "6 %", "rotation.value": ["-50 deg/s", "50 deg/s"]}
    given: dict[str, Any] = {"constants": {"trim.output": "7.05..7.09 V"}, "seconds": 600.0, "workers": 1}
    found = prove(fibre_optic(), tolerances=tolerances, gain_margin="18 dB", **given)
    assert status(found) == ["proved"] * 3
    assert len(check_certificate(certificate(found))) == 3


@pytest.mark.exhaustive
def test_the_closed_loop_gyroscope_at_each_phase_of_its_carrier() -> None:
    """Its rate loop has 30 dB and 75.6 deg where the run has settled."""
    graph = read_study("library:closed_loop_gyroscope").graph
    found = prove(graph, "rate", gain_margin="25 dB", phase_margin="70 deg", seconds=6000, workers=1)
    assert status(found) == ["proved"] * 3
    assert len(check_certificate(certificate(found))) == 3


class Held(NamedTuple):
    held: float


def test_a_number_that_others_follow_is_not_alone_where_it_started() -> None:
    """x' = (0.5 + 0.1 p) x, p' = p: at p = 1, where p has always been, the map of x follows it."""
    entries: Any = [("x", "held", -1), ("p", "held", -1)]

    def memory(x: float, p: float) -> Memory:
        return Memory(0, {"x": Held(x), "p": Held(p)}, {}, {}, {})

    def mapped(at: Memory) -> Any:
        x, p = (float(at.states[name][0]) for name in "xp")
        return np.array([[0.5 + 0.1 * p, 0.1 * x], [0.0, 1.0]])

    def after(at: Memory) -> Memory:
        x, p = (float(at.states[name][0]) for name in "xp")
        return memory((0.5 + 0.1 * p) * x, p)

    there = memory(2.0, 1.0)
    place, _ = Around(entries, there, Rings(), after, there, mapped).place(
        entries[1], {entries[1]: 1.0, entries[0]: 0.0}
    )
    assert (place.alone, place.turns, place.low, place.high) == (False, False, 1.0, 1.0)
