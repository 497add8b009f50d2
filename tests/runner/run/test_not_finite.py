"""Numbers that stop being finite end a run in both engines, with the same words."""

import math
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from proofmass.blocks import AnalogToDigital, Constant, Gain, Ramp, Saturation, Sum, UnitDelay
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.run import simulate as simulation
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import RunError, simulate

ENGINES: list[EngineName] = ["python", "compiled"]


class Divided(Block):
    """One over the input."""

    input = Input("1", "Input.")


@Divided.output("1")
def divided(p: Any, input: float) -> float:
    """One over the input."""
    return 1.0 / input


class Root(Block):
    """The square root of the input."""

    input = Input("1", "Input.")


@Root.output("1")
def root(p: Any, input: float) -> float:
    """The square root of the input."""
    return math.sqrt(input)


class Grown(NamedTuple):
    level: float


class Growing(Block):
    """A state that no output shows before it is infinite."""

    factor: float = param("1", "Factor of growth.", default=1e30)


@Growing.start
def start(p: Growing) -> Grown:
    return Grown(1.0)


@Growing.output("1")
def level(p: Growing, x: Grown) -> float:
    """The state."""
    return x.level


@Growing.update
def update(p: Growing, x: Grown) -> Grown:
    return Grown(x.level * p.factor)


def falling_to_zero(block: Block, port: str) -> Graph:
    """A ramp 0.2, 0.1, 0.0, ... through a block, and its output through a limiter, which would swallow an infinity."""
    return Graph(
        name="falling",
        rate="10 Hz",
        blocks={"ramp": Ramp(slope=-1.0, offset=0.5), "block": block, "limit": Saturation(lowest=-1.0, highest=1.0)},
        wires=["ramp.output -> block.input", f"block.{port} -> limit.input"],
        probes=["limit.output"],
    )


class TestNumbersThatAreNotFinite:
    def refused(self, graph: Graph, samples: int = 5000) -> str:
        """What both engines say, which must be the same, whatever the chunks."""
        texts = set()
        for engine in ENGINES:
            for first in (1, 16, 100_000):
                with pytest.MonkeyPatch.context() as patch:
                    patch.setattr(simulation, "FIRST_CHUNK", first)
                    with pytest.raises(RunError) as caught:
                        simulate(graph, samples=samples, engine=engine)
                texts.add(str(caught.value))
                assert caught.value.problem.key
        assert len(texts) == 1, texts
        return texts.pop()

    @pytest.mark.friendly(22, "an unstable loop")
    def test_an_unstable_loop(self) -> None:
        graph = Graph(
            name="unstable",
            rate="1 kHz",
            blocks={"one": Constant(value=1.0), "sum": Sum(), "gain": Gain(gain=-3.0), "delay": UnitDelay()},
            wires=[
                "one.output -> sum.first",
                "delay.output -> sum.second",
                "sum.output -> gain.input",
                "gain.output -> delay.input",
            ],
            probes=["one.output"],
        )
        text = self.refused(graph)
        assert text.startswith("gain.output: is not finite in tick 646, t = 0.646 s")
        assert "got:      inf" in text or "got:      -inf" in text
        assert "probe what drives it: input = sum.output" in text

    @pytest.mark.friendly(22, "a division by zero that a limiter would swallow")
    def test_a_division_by_zero_in_one_tick_that_a_limiter_would_swallow(self) -> None:
        text = self.refused(falling_to_zero(Divided(), "divided"))
        assert text.startswith("block.divided: failed in tick 5, t = 0.5 s")
        assert "ZeroDivisionError" in text
        assert "input = ramp.output" in text

    def test_a_root_of_a_negative_number(self) -> None:
        text = self.refused(falling_to_zero(Root(), "root"))
        assert text.startswith("block.root: failed in tick 6, t = 0.6 s")
        assert "ValueError: math domain error" in text or "ValueError: expected a nonnegative input, got -0.1" in text

    def test_one_that_ends_in_an_integer(self) -> None:
        graph = falling_to_zero(Root(), "root")
        blocks = {**graph.blocks, "limit": AnalogToDigital(), "volt": Gain(gain=1.0, output_unit="V")}
        wires = ["ramp.output -> block.input", "block.root -> volt.input", "volt.output -> limit.voltage"]
        graph = Graph(name="adc", rate="10 Hz", blocks=blocks, wires=wires, probes=["limit.code"])
        assert self.refused(graph).startswith("block.root: failed in tick 6")

    def test_an_overflow_into_a_converter(self) -> None:
        blocks = {"grow": Growing(), "volt": Gain(gain=1.0, output_unit="V"), "adc": AnalogToDigital()}
        wires = ["grow.level -> volt.input", "volt.output -> adc.voltage"]
        graph = Graph(name="adc", rate="10 Hz", blocks=blocks, wires=wires, probes=["adc.code"])
        text = self.refused(graph)
        assert text.startswith("grow.level: is not finite in tick 11, t = 1.1 s")

    def test_in_a_slow_block(self) -> None:
        blocks = {"grow": Growing(), "limit": Saturation(lowest=-1.0, highest=1.0)}
        graph = Graph(
            name="slow",
            rate="10 Hz",
            blocks=blocks,
            rates={"grow": "2 Hz"},
            wires=["grow.level -> limit.input"],
            probes=["limit.output"],
        )
        assert self.refused(graph).startswith("grow.level: is not finite in tick 55, t = 5.5 s")

    @pytest.mark.parametrize("engine", ENGINES)
    def test_huge_numbers_are_numbers(self, engine: EngineName) -> None:
        blocks = {f"huge_{number}": Constant(value=1.5e308) for number in range(3)}
        graph = Graph(name="huge", rate="1 Hz", blocks=blocks, probes=["huge_0.output"])
        assert (simulate(graph, samples=300, engine=engine)["huge_0.output"].values == 1.5e308).all()

    @pytest.mark.friendly(22, "the line of the block in its file")
    def test_the_place_in_the_file_is_told(self, tmp_path: Path) -> None:
        path = tmp_path / "grow.toml"
        path.write_text(
            'name = "grow"\nrate = "10 Hz"\nwires = ["a.output -> b.input", "b.output -> a.input"]\n'
            'probes = ["b.output"]\n[blocks.a]\nkind = "UnitDelay"\ninitial = 1.0\n'
            '[blocks.b]\nkind = "Gain"\ngain = 1e30\n'
        )
        with pytest.raises(RunError) as caught:
            simulate(read_graph(path), samples=50, engine="python")
        assert caught.value.problem.line == 8
        assert caught.value.problem.file == str(path)
