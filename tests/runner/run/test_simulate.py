"""One run: what must not change its bits, how long it is, and what ends it."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Correlator,
    DigitalToAnalog,
    Gain,
    MassSpringDamper,
    OneBitActuator,
    Ramp,
    ShiftRegister,
    Sum,
    UnitDelay,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Probe
from proofmass.runner.planning.plan import Plan, plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run import engines
from proofmass.runner.run import simulate as simulation
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.engines import choose
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from proofmass.runner.run.trace_size import refuse_large
from proofmass.runner.targets.llvm_text import content_of

ENGINES: list[EngineName] = ["python", "compiled"]


def content(graph: Graph) -> str:
    """What the program of a graph computes."""
    return content_of(write_tick(plan(graph)).program)


def bits(result: Result) -> dict[str, bytes]:
    """Every trace as its bytes."""
    return {name: np.ascontiguousarray(trace.values).tobytes() for name, trace in result.traces.items()}


def self_test() -> Graph:
    """Slow and fast probes, integer vectors, noise: a graph that has it all."""
    return Graph(
        name="all",
        rate="10 kHz",
        blocks={
            "chips": ShiftRegister(length=4, taps=0xC, seed=1),
            "level": OneBitActuator(level=1.0, unit="V"),
            "noise": WhiteNoise(density=0.01, unit="V"),
            "sum": Sum(unit="V"),
            "adc": AnalogToDigital(bits=12, reference=4.0),
            "cells": Correlator(cells=3, chips=15),
            "slow": UnitDelay(unit="V"),
        },
        rates={"slow": "10/7 kHz"},
        wires=[
            "chips.bit -> level.bit",
            "level.output -> sum.first",
            "noise.output -> sum.second",
            "sum.output -> adc.voltage",
            "sum.output -> slow.input",
            "adc.code -> cells.code",
            "chips.bit -> cells.bit",
        ],
        probes=["adc.code", {"signal": "sum.output", "every": 3}, "cells.impulse_response", "slow.output", "chips.bit"],
        seed=5,
    )


class TestNothingElseChangesABit:
    @pytest.mark.exhaustive
    @pytest.mark.parametrize("engine", ENGINES)
    @settings(max_examples=6)
    @given(first=st.integers(1, 400), largest=st.integers(8, 4000), patience=st.sampled_from([0.0, 1e-4, 1.0]))
    def test_not_the_size_of_chunks(self, engine: EngineName, first: int, largest: int, patience: float) -> None:
        whole = bits(simulate(self_test(), samples=500, engine="python"))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(simulation, "FIRST_CHUNK", first)
            patch.setattr(simulation, "CHUNK_SECONDS", patience)
            patch.setattr(simulation, "CHUNK_BYTES", largest)
            assert bits(simulate(self_test(), samples=500, engine=engine)) == whole

    def test_not_the_order_of_probes(self) -> None:
        graph = self_test()
        turned = Graph(**{**vars(graph), "probes": graph.probes[::-1]})
        result, other = (simulate(g, samples=100, engine="python") for g in (graph, turned))
        assert list(other) == list(result)[::-1]
        assert bits(other) == bits(result)
        assert content(turned) == content(graph)
        assert other.provenance["graph_hash"] == result.provenance["graph_hash"]

    @pytest.mark.exhaustive
    def test_not_the_hash_seed_of_python(self) -> None:
        script = (
            "import sys, hashlib; from proofmass import read_graph, simulate;"
            "from proofmass.runner.program.tick import write_tick; from proofmass.runner.planning.plan import plan;"
            "from proofmass.runner.targets.llvm_text import llvm_text;"
            "graph = read_graph(sys.argv[1]); result = simulate(graph, samples=300, engine='python');"
            "rows = b''.join(trace.values.tobytes() for trace in result.traces.values());"
            "data = llvm_text(write_tick(plan(graph)).program).encode() + rows;"
            "print(hashlib.sha256(data).hexdigest(), result.provenance['graph_hash'])"
        )
        command = [sys.executable, "-c", script, str(library_file("recorded_motion.toml"))]
        answers = {
            subprocess.run(
                command, env=os.environ | {"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
            ).stdout
            for seed in ("0", "1", "random")
        }
        assert len(answers) == 1

    @pytest.mark.exhaustive("compiled")
    @pytest.mark.parametrize("engine", ENGINES)
    def test_noise_is_a_function_of_seed_block_and_tick(self, engine: EngineName) -> None:
        def noise(seed: int, **more: Any) -> np.ndarray[Any, Any]:
            blocks: dict[str, Block] = {"noise": WhiteNoise(density=1.0), **more.pop("blocks", {})}
            probes = ["noise.output", *more.pop("probes", [])]
            graph = Graph(name="noise", rate="1 kHz", blocks=blocks, probes=probes, **more)
            return simulate(graph, samples=400, seed=seed, engine=engine)["noise.output"].values

        alone = noise(1)
        assert np.array_equal(alone, noise(1, blocks={"another": WhiteNoise(density=1.0)}, probes=["another.output"]))
        beside_a_faster_one = noise(1, blocks={"a": WhiteNoise(density=1.0)}, rates={"a": "3 kHz"})
        assert np.array_equal(alone[:134], beside_a_faster_one)
        assert not (alone == noise(2)).any()
        assert abs(np.corrcoef(alone, noise(2))[0, 1]) < 0.2
        renamed = Graph(name="noise", rate="1 kHz", blocks={"other": WhiteNoise(density=1.0)}, probes=["other.output"])
        assert not (simulate(renamed, samples=400, seed=1, engine=engine)["other.output"].values == alone).any()


class TestLength:
    @pytest.mark.parametrize("engine", ENGINES)
    def test_a_duration_has_both_ends_and_tick_0_is_at_0(self, engine: EngineName) -> None:
        graph = Graph(name="time", rate="10 Hz", blocks={"ramp": Ramp(slope=1.0)}, probes=["ramp.output"])
        trace = simulate(graph, duration="1 s", engine=engine)["ramp.output"]
        assert len(trace.values) == 11
        assert trace.times[0] == trace.values[0] == 0.0
        assert trace.times[-1] == trace.values[-1] == 1.0
        assert len(simulate(graph, duration=0.99, engine=engine)["ramp.output"].values) == 10
        assert len(simulate(graph, duration=0, engine=engine)["ramp.output"].values) == 1
        assert len(simulate(graph, samples=10, engine=engine)["ramp.output"].values) == 10

    def test_the_graph_says_unless_the_caller_does(self) -> None:
        blocks = {"ramp": Ramp(slope=1.0)}
        lasting = Graph(name="time", rate="10 Hz", blocks=blocks, probes=["ramp.output"], duration="2 s")
        counted = Graph(name="time", rate="10 Hz", blocks=blocks, probes=["ramp.output"], samples=7)
        assert simulate(lasting).ticks == 21
        assert simulate(lasting, samples=3).ticks == 3
        assert simulate(counted).ticks == 7
        assert simulate(counted, duration="1 s").ticks == 11

    @pytest.mark.parametrize(
        ("wanted", "message"),
        [
            ({}, "how long to run is not said"),
            ({"samples": 0}, "samples: must be an integer of at least 1"),
            ({"samples": 2.5}, "samples: must be an integer of at least 1"),
            ({"samples": True}, "samples: must be an integer of at least 1"),
            ({"samples": 10**13}, "too long"),
            ({"duration": "3 m"}, "duration: "),
            ({"duration": -1.0}, "duration: must not be negative"),
            ({"duration": "1e9 s"}, "too long"),
            ({"duration": "1 s", "samples": 3}, "give samples or duration, not both"),
            ({"samples": 3, "seed": -1}, "seed: must be an integer"),
            ({"samples": 3, "seed": 2**63}, "seed: must be an integer"),
            ({"samples": 3, "engine": "complied"}, "did you mean compiled?"),
        ],
    )
    def test_what_cannot_be_is_refused(self, wanted: dict[str, Any], message: str) -> None:
        graph = Graph(name="time", rate="10 kHz", blocks={"ramp": Ramp(slope=1.0)}, probes=["ramp.output"])
        with pytest.raises(ModelError) as caught:
            simulate(graph, **wanted)
        assert message in str(caught.value)


class TestEngines:
    def test_auto_takes_the_one_that_is_ready_sooner(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        planned = plan(self_test())
        assert choose(planned, 100, "auto") == "python"
        assert choose(planned, 10**6, "auto") == "compiled"
        assert choose(planned, 10**6, "python") == "python"
        between = 4_000
        monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr("proofmass.runner.targets.machine_code._loaded", {})
        assert choose(planned, between, "auto") == "python"
        assert simulate(self_test(), samples=20, engine="auto").provenance["engine"] == "python"
        assert simulate(self_test(), samples=20, engine="compiled").provenance["engine"] == "compiled"
        assert choose(planned, between, "auto") == "compiled"

    def test_long_buffers_are_slow_in_plain_python(self) -> None:
        cells = {
            "bit": ShiftRegister(),
            "cells": Correlator(cells=4096),
            "code": AnalogToDigital(),
            "v": Constant(unit="V"),
        }
        wires = ["bit.bit -> cells.bit", "v.output -> code.voltage", "code.code -> cells.code"]
        graph = Graph(name="cells", rate="1 kHz", blocks=cells, wires=wires, probes=["cells.impulse_response"])
        assert choose(plan(graph), 5_000, "auto") == "compiled"

    @pytest.mark.parametrize("engine", ENGINES)
    def test_probes_of_every_kind(self, engine: EngineName) -> None:
        result = simulate(self_test(), samples=61, engine=engine)
        every = simulate(
            Graph(**{**vars(self_test()), "probes": ["sum.output"]}),
            samples=61,
            engine=engine,
        )
        assert np.array_equal(result["sum.output"].values, every["sum.output"].values[::3])
        assert result["cells.impulse_response"].values.shape == (5, 3)
        assert result["cells.impulse_response"].values.dtype == np.int64
        assert not result["cells.impulse_response"].values[0].any()
        assert result["cells.impulse_response"].values[1:].all()
        assert result["slow.output"].values.shape == (9,)
        assert result["chips.bit"].values.dtype == np.bool_

    @pytest.mark.parametrize("engine", ENGINES)
    def test_a_driven_parameter_is_what_drives_it(self, engine: EngineName) -> None:
        graph = Graph(
            name="driven",
            rate="1 kHz",
            blocks={
                "number": Ramp(slope=400.0, offset=-0.3),
                "reference": Ramp(slope=3.0, offset=2.0, unit="V"),
                "dac": DigitalToAnalog(bits=8, reference=7.0),
            },
            rates={"reference": "1/5 kHz"},
            wires=["number.output -> dac.number", "reference.output -> dac.reference"],
            probes=["dac.voltage"],
        )
        expected = []
        for tick in range(400):
            held = 2.0 + 3.0 * (tick // 5 * 5 * 0.001)
            code = round(min(max(-0.3 + 400.0 * (tick * 0.001), -128.0), 127.0))
            expected.append(code * (held / 128.0))
        found = simulate(graph, samples=400, engine=engine)["dac.voltage"].values
        assert found == pytest.approx(expected, rel=1e-15)
        assert len(set(found)) > 80


class TestTracesTooLargeForMemory:
    def test_they_are_refused_with_the_cure(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(simulation, "IN_MEMORY", 1 << 20)
        graph = Graph(name="long", rate="1 kHz", blocks={"ramp": Ramp(slope=1.0)}, probes=["ramp.output"])
        with pytest.raises(ModelError) as caught:
            simulate(graph, samples=(1 << 17) + 1)
        assert "at most 1 MiB without a folder" in str(caught.value)
        assert "--out FOLDER" in str(caught.value)
        refuse_large(plan(graph), 1 << 17, 1 << 20)

    @pytest.mark.exhaustive("python")
    @pytest.mark.parametrize("engine", ENGINES)
    def test_they_are_streamed_into_a_folder(
        self, engine: EngineName, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        whole = bits(simulate(self_test(), samples=3000, engine=engine))
        monkeypatch.setattr(simulation, "IN_MEMORY", 1000)
        monkeypatch.setattr(simulation, "CHUNK_BYTES", 3000)
        result = simulate(self_test(), samples=3000, engine=engine, folder=tmp_path / "out")
        assert bits(result) == whole
        for name, trace in result.traces.items():
            assert isinstance(trace.values, np.memmap)
            assert np.load(tmp_path / "out" / f"{name}.npy").tobytes() == whole[name]


def test_like_runs_add_up_until_compiling_is_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engines, "_spent", {})
    monkeypatch.setattr("proofmass.runner.targets.native.already_compiled", lambda *_: False)

    def variant(gain: float) -> Plan:
        blocks = {"ramp": Ramp(), "gain": Gain(gain=gain)}
        return plan(Graph(name="variant", rate=1000, blocks=blocks, wires=["ramp.output -> gain.input"]))

    chosen = [choose(variant(1.0 + number), 10_000, "auto") for number in range(12)]
    assert chosen == ["python"] * chosen.count("python") + ["compiled"] * chosen.count("compiled")
    assert chosen[0] == "python"
    assert chosen[-1] == "compiled"


def test_steps_of_continuous_blocks_count_in_the_choice() -> None:
    def of(method: str) -> Plan:
        graph = Graph(
            name="fine",
            rate=1000,
            blocks={"push": Constant(unit="N"), "mass": MassSpringDamper()},
            wires=["push.output -> mass.force"],
            integration={"method": method} | ({} if method == "exact" else {"substeps": 500}),
        )
        return plan(graph)

    assert choose(of("exact"), 1000, "auto") == "python"
    assert choose(of("runge_kutta_4"), 1000, "auto") == "compiled"


def test_a_run_that_ends_before_its_text_is_written_is_interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = {"ramp": Ramp(), "gain": Gain()}
    planned = plan(Graph(name="short", rate=1000, blocks=blocks, wires=["ramp.output -> gain.input"]))
    monkeypatch.setattr(engines, "_spent", {engines._likeness(planned): 10.0})
    asked: list[int] = []
    assert choose(planned, 10, "auto", lambda: bool(asked.append(10))) == "python"
    assert not asked
    assert choose(planned, 1_000, "auto") == "compiled"


@pytest.mark.defect("C891", before="Invalid literal for Fraction: 'np.float64(1000.0)'", after="a number as any other")
def test_numbers_of_numpy_are_numbers() -> None:
    at: dict[str, Any] = {"rate": np.float64(1000.0), "samples": np.int64(5), "seed": np.int64(3)}
    probe = Probe("ramp.output", every=np.int64(2))  # type: ignore[arg-type]
    graph = Graph(name="numpy", blocks={"ramp": Ramp()}, values={"level": np.float64(2.0)}, probes=[probe], **at)
    assert simulate(graph)["ramp.output"].times.tolist() == [0.0, 0.002, 0.004]
    assert simulate(graph, duration=np.float64(0.01)).ticks == 11
    assert simulate(graph, samples=np.int32(7), seed=np.int64(9)).seed == 9  # type: ignore[arg-type]
