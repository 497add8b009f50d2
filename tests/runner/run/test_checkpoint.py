"""Runs that are interrupted, or run out of room, and go on to the same bits."""

import importlib.util
import json
import linecache
import os
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from proofmass.blocks import (
    AnalogToDigital,
    Correlator,
    MassSpringDamper,
    OneBitActuator,
    RecordedSignal,
    ShiftRegister,
    Sum,
    TransferFunction,
    WhiteNoise,
)
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Place
from proofmass.runner.planning.plan import plan
from proofmass.runner.run import simulate as simulation
from proofmass.runner.run.checkpoint import FILE
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.recorder import Recorder
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from proofmass.runner.run.trace_size import refuse_full

ENGINES: list[EngineName] = ["python", "compiled"]
OWN = """from typing import Any
from proofmass import block
@block("1", input="1")
def mine(p: Any, input: float) -> float:
    \"\"\"Mine.\"\"\"
    return {} * input
"""


def made(folder: Path, **changes: Any) -> Graph:
    """States, buffers, noise, vectors, slow probes, continuous blocks and a recording."""
    folder.mkdir(exist_ok=True)
    if not (folder / "recorded.csv").exists():
        (folder / "recorded.csv").write_text(
            "time [s],level [V]\n" + "".join(f"{n / 50},{n * n % 7}\n" for n in range(40))
        )
    blocks = {
        "chips": ShiftRegister(length=4, taps=0xC, seed=1),
        "level": OneBitActuator(level=1e-6),
        "mass": MassSpringDamper(damping=1e-4),
        "noise": WhiteNoise(density=0.01, unit="V"),
        "recorded": RecordedSignal(file="recorded.csv", unit="V"),
        "readout": TransferFunction(numerator=(3e6,), denominator=(1e-4, 1.0), input_unit="m", output_unit="V"),
        "sum": Sum(unit="V"),
        "adc": AnalogToDigital(bits=16, reference=16.0),
        "cells": Correlator(cells=3, chips=15),
    }
    facts: dict[str, Any] = {
        "name": "all",
        "rate": "10 kHz",
        "wires": [
            "chips.bit -> level.bit",
            "level.output -> mass.force",
            "mass.displacement -> readout.input",
            "readout.output -> sum.first",
            "noise.output -> sum.second",
            "recorded.output -> sum.third",
            "sum.output -> adc.voltage",
            "adc.code -> cells.code",
            "chips.bit -> cells.bit",
        ],
        "probes": ["adc.code", {"signal": "sum.output", "every": 3}, "cells.impulse_response", "chips.bit"],
        "seed": 5,
        "place": Place(folder=str(folder)),
    }
    return Graph(**{**facts, **changes, "blocks": {**blocks, **changes.get("blocks", {})}})


def bits(result: Result) -> dict[str, bytes]:
    """Every trace as its bytes."""
    return {name: np.ascontiguousarray(trace.values).tobytes() for name, trace in result.traces.items()}


def interrupt_after(ticks: int, number: int = signal.SIGINT) -> Callable[[int, int], None]:
    """A progress that interrupts this process, once."""
    sent: list[int] = []

    def progress(done: int, total: int) -> None:
        if done >= ticks and not sent:
            sent.append(done)
            os.kill(os.getpid(), number)

    return progress


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "CHUNK_BYTES", 700)


def _killed(*_: object) -> None:
    raise SystemExit


@pytest.mark.defect(
    "H914", before="`there is no adc.code.npy to resume from`, or `adc.code.npy is too short`", after="goes on"
)
@pytest.mark.parametrize("streamed", [True, False])
def test_a_run_goes_on_that_is_killed_while_it_goes_on(
    streamed: bool, tmp_path: Path, small_chunks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed as soon as the head of a file is written for the rest, or in the middle of the next checkpoint."""
    graph, folder = made(tmp_path), tmp_path / "run"
    expected = bits(simulate(graph, duration="0.1 s"))
    monkeypatch.setattr(simulation, "IN_MEMORY", 0 if streamed else 1 << 30)
    simulate(graph, duration="0.1 s", folder=folder, progress=interrupt_after(200))
    with monkeypatch.context() as patch:
        if streamed:
            head = Recorder._write_head
            patch.setattr(Recorder, "_write_head", lambda *given: _killed(head(*given)))
        else:
            patch.setattr(
                np, "save", lambda to, _: _killed((to.write_bytes if isinstance(to, Path) else to.write)(b""))
            )
        with pytest.raises(SystemExit):
            simulate(graph, duration="0.1 s", folder=folder, progress=interrupt_after(500))
    assert bits(simulate(graph, duration="0.1 s", folder=folder)) == expected


@pytest.mark.usefixtures("small_chunks")
class TestGoingOn:
    @pytest.mark.exhaustive(but=1)
    @pytest.mark.parametrize("streamed", [False, True], ids=["in memory", "streamed"])
    @pytest.mark.parametrize("engine", ENGINES)
    @settings(
        max_examples=settings.default.max_examples // 25, suppress_health_check=[HealthCheck.function_scoped_fixture]
    )
    @given(at=st.lists(st.integers(0, 1900), min_size=1, max_size=3).map(sorted))
    def test_to_the_same_bits(
        self, engine: EngineName, streamed: bool, at: list[int], tmp_path_factory: pytest.TempPathFactory
    ) -> None:
        folder = tmp_path_factory.mktemp("run")
        graph = made(folder)
        whole = bits(simulate(graph, samples=2000, engine="python"))
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(simulation, "IN_MEMORY", 100 if streamed else 1 << 28)
            resume = False
            for ticks in at:
                progress = interrupt_after(ticks)
                result = simulate(graph, samples=2000, engine=engine, folder=folder, progress=progress, resume=resume)
                assert result.interrupted
                assert ticks <= result.ticks < 2000
                resume = True
            half = bits(result)
            result = simulate(graph, samples=2000, engine=engine, folder=folder, resume=True)
        assert not result.interrupted
        assert bits(result) == whole
        assert all(whole[name].startswith(rows) for name, rows in half.items())
        files = {path.name for path in folder.iterdir()} - {"recorded.csv"}
        assert files == ({f"{name}.npy" for name in whole} if streamed else set())
        for name in whole if streamed else ():
            assert np.load(folder / f"{name}.npy").tobytes() == whole[name]

    @pytest.mark.exhaustive
    def test_the_engines_take_over_from_each_other(self, tmp_path: Path) -> None:
        graph = made(tmp_path)
        whole = bits(simulate(graph, samples=2000, engine="python"))
        engines: list[EngineName] = ["python", "compiled", "python"]
        for ticks, engine in zip((300, 900, 1500), engines, strict=True):
            progress = interrupt_after(ticks)
            simulate(graph, samples=2000, engine=engine, folder=tmp_path, progress=progress, resume=ticks > 300)
        assert bits(simulate(graph, samples=2000, engine="compiled", folder=tmp_path, resume=True)) == whole

    def test_a_killed_process_that_had_been_resumed_loses_only_what_it_added(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        graph = made(tmp_path)
        whole = bits(simulate(graph, samples=2000, engine="python"))["adc.code"]
        monkeypatch.setattr(simulation, "IN_MEMORY", 100)
        simulate(graph, samples=2000, engine="python", folder=tmp_path, progress=interrupt_after(500))

        def killed(done: int, total: int) -> None:
            if done > 1200:
                raise SystemExit("killed")

        with pytest.raises(SystemExit):
            simulate(graph, samples=2000, engine="python", folder=tmp_path, progress=killed, resume=True)
        result = simulate(graph, samples=2000, engine="python", folder=tmp_path, resume=True)
        assert bits(result)["adc.code"] == whole

    def test_sigterm_is_an_interruption_too(self, tmp_path: Path) -> None:
        before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
        progress = interrupt_after(100, signal.SIGTERM)
        assert simulate(made(tmp_path), samples=2000, engine="python", progress=progress).interrupted
        assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before

    def test_a_whole_run_leaves_no_checkpoint(self, tmp_path: Path) -> None:
        simulate(made(tmp_path), samples=200, engine="python", folder=tmp_path / "out")
        assert not list((tmp_path / "out").iterdir())


@pytest.mark.usefixtures("small_chunks")
class TestRefused:
    @pytest.fixture
    def folder(self, tmp_path: Path) -> Path:
        simulate(made(tmp_path), samples=2000, engine="python", folder=tmp_path / "out", progress=interrupt_after(700))
        return tmp_path / "out"

    def message(self, folder: Path, graph: Graph | None = None, **changes: Any) -> str:
        options: dict[str, Any] = {"samples": 2000, **changes}
        with pytest.raises(ModelError) as caught:
            simulate(graph or made(folder.parent), engine="python", folder=folder, resume=True, **options)
        text = str(caught.value)
        assert str(folder / FILE) in text
        assert "--restart, or resume=False" in text
        return text

    def test_without_a_checkpoint(self, tmp_path: Path) -> None:
        assert "there is no checkpoint.json to resume from" in self.message(tmp_path / "nothing", made(tmp_path))
        with pytest.raises(ValueError, match="needs the folder"):
            simulate(made(tmp_path), samples=10, resume=True)

    def test_the_same_run_goes_on_by_itself_and_another_is_refused(self, folder: Path) -> None:
        whole = simulate(made(folder.parent), samples=2000, engine="python")
        with pytest.raises(ModelError, match="the seed changed"):
            simulate(made(folder.parent), samples=2000, engine="python", folder=folder, seed=6)
        assert (folder / FILE).exists()
        starts: list[int] = []
        result = simulate(
            made(folder.parent),
            samples=2000,
            engine="python",
            folder=folder,
            progress=lambda done, _: starts.append(done),
        )
        assert starts[0] >= 700
        assert result.digest == whole.digest
        assert not (folder / FILE).exists()

    def test_a_run_that_is_not_to_go_on_starts_at_tick_0(self, folder: Path) -> None:
        starts: list[int] = []
        options = {"engine": "python", "folder": folder, "resume": False}
        simulate(made(folder.parent), samples=1000, progress=lambda done, _: starts.append(done), **options)
        assert starts[0] == 0
        assert not (folder / FILE).exists()

    def test_traces_that_do_not_fit_on_the_disk(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(2**40, 2**40 - 2**30, 2**30))
        with pytest.raises(ModelError, match="do not fit on the disk") as refused:
            simulate(made(tmp_path), samples=10**9, engine="compiled", folder=tmp_path / "new" / "out")
        (problem,) = refused.value.problems
        assert problem.expected == f"at most 1.0 GiB, which {tmp_path} has left"
        assert not (tmp_path / "new").exists()

    def test_traces_that_just_fit(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        graph = made(tmp_path)
        size = sum(trace.values.nbytes for trace in simulate(graph, samples=1000, engine="python").traces.values())
        disks = [shutil._ntuple_diskusage(2**40, 2**40 - free, free) for free in (size, size - 1)]
        monkeypatch.setattr(shutil, "disk_usage", lambda _: disks.pop(0))
        refuse_full(plan(graph), 1000, tmp_path / "enough")
        with pytest.raises(ModelError, match="do not fit on the disk"):
            refuse_full(plan(graph), 1000, tmp_path / "short")

    def test_another_parameter(self, folder: Path) -> None:
        text = self.message(folder, made(folder.parent, blocks={"adc": AnalogToDigital(bits=14, reference=16.0)}))
        assert "the graph changed" in text
        assert "got:      [blocks.adc] bits = 14" in text
        assert "expected: [blocks.adc] bits = 16" in text

    def test_another_seed_or_length(self, folder: Path) -> None:
        text = self.message(folder, seed=6)
        assert "the seed changed" in text
        assert "got:      6" in text
        assert "expected: 5" in text
        assert "the number of ticks changed" in self.message(folder, samples=2001)

    def test_another_recording(self, folder: Path) -> None:
        path = folder.parent / "recorded.csv"
        path.write_text(path.read_text().replace("0.78,", "0.7801,"))
        assert "the recordings changed" in self.message(folder)

    def test_another_function_of_a_block(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """Also where bytecode that Python kept of a file as long, of the same second, is not that of the text."""
        monkeypatch.setattr(sys, "dont_write_bytecode", False)

        def graph(factor: float) -> Graph:
            (tmp_path / "mine.py").write_text(OWN.format(factor))
            os.utime(tmp_path / "mine.py", (1e9, 1e9))
            kind = load_own_blocks(tmp_path / "mine.py")["Mine"]
            blocks = {"noise": WhiteNoise(density=1.0), "mine": kind()}
            wires = ["noise.output -> mine.input"]
            return Graph(name="mine", rate="1 kHz", blocks=blocks, wires=wires, probes=["mine.mine"])

        out = tmp_path / "out"
        simulate(graph(2.0), samples=2000, engine="python", folder=out, progress=interrupt_after(100))
        assert "the code of a block changed" in self.message(out, graph(3.0))
        simulate(graph(2.0), samples=2000, engine="python", folder=out, resume=True)

    def test_a_function_of_a_block_whose_file_was_written_again_after_it_was_loaded(self, tmp_path: Path) -> None:
        file = tmp_path / "mine.py"
        file.write_text(OWN.format(2.0))
        spec = importlib.util.spec_from_file_location("loaded_by_python_itself", file)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        file.write_text(OWN.format(3.0))
        linecache.checkcache(str(file))
        wires = ["noise.output -> mine.input"]
        blocks = {"noise": WhiteNoise(density=1.0), "mine": module.mine()}
        graph = Graph(name="mine", rate="1 kHz", blocks=blocks, wires=wires, probes=["mine.mine"])
        with pytest.raises(ModelError, match=r"mine\.py:3: Mine.mine: its file has changed since it was loaded"):
            simulate(graph, samples=10, engine="python")

    @pytest.mark.parametrize("damage", ["", "{", "[]", '{"run": {}}', "\0\0", "half"])
    def test_a_damaged_checkpoint(self, folder: Path, damage: str) -> None:
        path = folder / FILE
        text = path.read_text()
        path.write_text(text[: len(text) // 2] if damage == "half" else damage)
        assert "the checkpoint is damaged" in self.message(folder)

    @pytest.mark.parametrize("key", ["states", "wires", "buffers", "rows", "tick"])
    def test_a_checkpoint_that_lacks_something(self, folder: Path, key: str) -> None:
        data = json.loads((folder / FILE).read_text())
        del data[key]
        (folder / FILE).write_text(json.dumps(data))
        assert "the checkpoint is damaged" in self.message(folder)

    def test_traces_that_are_gone_or_cut(self, folder: Path) -> None:
        path = folder / "adc.code.npy"
        data = path.read_bytes()
        path.write_bytes(data[:-8])
        assert "adc.code.npy is too short" in self.message(folder)
        path.write_bytes(b"")
        assert "the checkpoint is damaged" in self.message(folder)
        path.unlink()
        assert "there is no adc.code.npy" in self.message(folder)
