"""Where something has no derivative: parameters at 0 are left out, signals at a corner are refused with their block."""

import json
import math
from pathlib import Path

import pytest

from proofmass.blocks import (
    BrownianForce,
    Constant,
    Delay,
    DiscreteIntegrator,
    FixedGain,
    FixedQuantiser,
    Gain,
    MassSpringDamper,
    Negation,
    Sum,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.period_map import period_map
from proofmass.runner.analysis.margins.margins import margins_at
from proofmass.runner.analysis.margins.sensitivity import margin_sensitivities
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan


def sensor_loop(**brownian: float) -> Graph:
    blocks: dict[str, Block] = {
        "push": BrownianForce(**brownian),
        "sum": Sum(unit="N"),
        "sensor": MassSpringDamper(damping=1e-3),
        "hold": UnitDelay(unit="m"),
        "minus": Gain(gain=-1.0, input_unit="m", output_unit="N"),
    }
    wires = [
        "push.force -> sum.first",
        "minus.output -> sum.second",
        "sum.output -> sensor.force",
        "sensor.displacement -> hold.input",
        "hold.output -> minus.input",
    ]
    return Graph(name="quiet", rate=10e3, duration=1e-3, blocks=blocks, wires=wires, probes=["hold.output"])


@pytest.mark.exhaustive
@pytest.mark.defect("C2", before="an error inside proofmass: ZeroDivisionError", after="the answer for any temperature")
def test_noise_that_is_switched_off_moves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Noise is zero where a graph is linearised, so that its temperature makes no difference, 0 K among them."""
    answers = []
    for temperature in (0.0, 300.0):
        path = tmp_path / "quiet.toml"
        path.write_text(write_graph(sensor_loop(temperature=temperature)))
        assert main(["margins", str(path), "--json", "--sensitivity", "sum.output", "hold.output"]) == 0
        answers.append(json.loads(capsys.readouterr().out)["sensitivities"])
    assert answers[0] == answers[1]
    assert answers[0][0]["value"] == pytest.approx(1.0 / (49.5627 + 1.0), rel=1e-6)


class Root(Block):
    """output = sqrt(offset) + sqrt(|input|)."""

    offset: float = param("1", "Below a square root.", default=0.0)
    input = Input("1", "Below a square root too.")


@Root.output("1")
def output(p: Root, input: float) -> float:
    """The sum."""
    return math.sqrt(p.offset) + math.sqrt(abs(input))


OWN = """
import math
from proofmass import Block, Input, param

class Root(Block):
    \"\"\"output = sqrt(offset) + sqrt(|input|).\"\"\"
    offset: float = param("1", "Below a square root.", default=0.0)
    input = Input("1", "Below a square root too.")

@Root.output("1")
def output(p: Root, input: float) -> float:
    \"\"\"The sum.\"\"\"
    return math.sqrt(p.offset) + math.sqrt(abs(input))
"""


def root(value: float) -> Graph:
    blocks: dict[str, Block] = {"source": Constant(value=value), "root": Root()}
    return Graph(name="root", rate=1000, blocks=blocks, wires=["source.output -> root.input"])


def test_a_parameter_with_an_infinite_slope_is_left_out_by_name() -> None:
    found = period_map(plan(root(4.0)), [("source", "output")], [("root", "output")], by_parameters=True)
    assert found.undefined == ("root.offset",)
    assert float(found.parts()[3][0, 0]) == 0.25
    assert float(found.slopes["source.value"][0, -1]) == pytest.approx(0.25)


def test_what_is_left_out_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "root.toml"
    own = tmp_path / "own.py"
    own.write_text(OWN)
    path.write_text(write_graph(root(4.0)))
    command = ["margins", str(path), "--blocks", str(own), "--sensitivity", "source.output", "root.output"]
    assert main(command) == 0
    assert (
        "  root.offset                                    none: a corner, or an infinite slope"
        in capsys.readouterr().out
    )
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["sensitivities"][0]["undefined"] == ["root.offset"]


@pytest.mark.defect("C2", before="got: float division by zero", after="a corner or an infinite slope, by its block")
def test_a_signal_with_an_infinite_slope_is_refused() -> None:
    with pytest.raises(ModelError) as caught:
        period_map(plan(root(0.0)), [("source", "output")], [("root", "output")])
    (problem,) = caught.value.problems
    assert (problem.key, problem.got) == ("blocks.root", "it has a corner here, or an infinite slope")


@pytest.mark.defect(
    "S968", before="-2.9 dB by a value that is also the ticks of a delay", after="no derivative: -4.65 dB from 3 to 4"
)
@pytest.mark.parametrize("follows", ["lag.ticks", "rate", "lag.clock_offset", "fixed.gain"])
def test_a_value_that_moves_a_rate_or_an_integer_has_no_derivative(follows: str) -> None:
    """The gain margin of an integrator K T / (z - 1) behind n ticks is 2 sin(pi / (2 (2 n + 1))) / (K T)."""
    formulas = {"control.gain": "= 10 Hz * number", follows: "= number" + _UNITS.get(follows, "")}
    graph = Graph(
        name="",
        rate="1 kHz",
        blocks={
            "lag": Delay(ticks=3),
            "control": DiscreteIntegrator(gain=30.0, output_unit="1"),
            "minus": Negation(),
            "quantiser": FixedQuantiser(),
            "fixed": FixedGain(gain=3.0),
        },
        wires=[
            "control.output -> lag.input",
            "lag.output -> minus.input",
            "minus.output -> control.input",
            "control.output -> quantiser.input",
            "quantiser.output -> fixed.input",
        ],
        values={"number": 3.0},
        formulas=formulas,
    )
    planned = plan(graph)
    points = OperatingPoints(planned)
    system = points.loop(("control", "output"), by_parameters=True)
    found = margins_at(system, "main", "control.output")
    gain, *_ = margin_sensitivities(planned, found, system)
    assert "number" not in {effect.parameter for effect in gain.effects}
    assert gain.undefined == ("number",)
    assert "control.gain" in {effect.parameter for effect in gain.effects}
    if follows == "lag.ticks":
        assert gain.value == pytest.approx(20.0 * math.log10(2.0 * math.sin(math.pi / 14.0) / 0.03), abs=1e-6)


_UNITS = {"rate": " * 100 Hz", "lag.clock_offset": " * 0.1 ms"}
