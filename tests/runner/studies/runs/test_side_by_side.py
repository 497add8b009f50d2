"""Studies in lanes and threads: every bit as one run after the other in plain Python, failures included."""

import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.host.interrupts import StoppedError
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.program.tick_loop import bytes_of_a_run, vectors_of
from proofmass.runner.run import side_by_side
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.graph_texts import changed
from tests.by_hand.study_texts import STUDY


def study_of(path: Path, text: str = STUDY) -> Study:
    path.write_text(text)
    return read_study(path)


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return study_of(tmp_path / "study.toml")


@pytest.mark.parametrize(
    ("size", "sizes"),
    [(1, [48, 35]), (1 << 24, [16, 16, 16, 16, 16, 3]), (1 << 25, [8] * 10 + [3]), (1 << 30, [8] * 10 + [3])],
)
def test_threads_get_as_many_parts_each_and_large_ones(size: int, sizes: list[int]) -> None:
    """83 runs in groups of 8 lanes, eleven of them, for two threads: one part each, if their memory allows it."""
    compiled = SimpleNamespace(compiled=SimpleNamespace(size=size))
    sensors: Any = SimpleNamespace(together=compiled, study=SimpleNamespace(epochs=(0.0,)), lanes=8, ticks=100)
    parts = list(SensorRuns.parts(sensors, np.arange(83), 2))
    assert [len(part) for part in parts] == sizes
    assert np.concatenate(parts).tolist() == list(range(83))


@pytest.mark.exhaustive
@pytest.mark.friendly(35, "threads and lanes give one digest")
def test_one_digest_whatever_the_lanes_and_threads(study: Study) -> None:
    expected = run_study(study, engine="python").digest
    for lanes, threads in ((0, 1), (0, 2), (8, 1), (8, 2), (16, 2), (32, 1)):
        assert run_study(study, engine="compiled", lanes=lanes, threads=threads).digest == expected, (lanes, threads)


@pytest.mark.exhaustive
@pytest.mark.defect(
    "C201", before="10 or 12 lanes ended the process, 3, 5 to 7 in errors", after="any number, one digest"
)
@pytest.mark.parametrize(
    "numbers",
    [
        pytest.param([*range(13), 16, 31, 33, 64], id="some"),
        pytest.param(range(65), id="all", marks=pytest.mark.exhaustive),
    ],
)
def test_any_number_of_lanes(study: Study, numbers: Sequence[int]) -> None:
    expected = run_study(study, engine="python").digest
    for lanes in numbers:
        assert run_study(study, engine="compiled", lanes=lanes, threads=1).digest == expected, lanes
    with pytest.raises(ModelError, match="lanes: out of range"):
        run_study(study, lanes=65)


def test_more_than_64_lanes_are_refused() -> None:
    assert side_by_side.whole_lanes(64) == 64
    for lanes in (-1, 65):
        with pytest.raises(ModelError, match=rf"(?s)lanes: out of range.*got: *{lanes}.*0 to 64"):
            side_by_side.whole_lanes(lanes)


@pytest.mark.exhaustive
def test_in_any_company(study: Study) -> None:
    """Which runs go side by side changes no bit of any."""
    alone = run_study(study, engine="python")
    sensors, numbers = SensorRuns(study, "compiled", 8), np.random.default_rng(3).permutation(12).tolist()
    for first in range(0, 12, 5):
        some = numbers[first : first + 5]
        found = sensors.runs(some, threading.Event())
        assert found.numbers.tolist() == some
        for place, name in enumerate(alone.values):
            assert found.values[:, :, place].tolist() == alone[name][some].tolist()


@pytest.mark.exhaustive
def test_sensors_that_fail_fail_alone(tmp_path: Path) -> None:
    """Some have a reference that no converter can have; of others the sum of three voltages is no number."""
    text = changed(
        STUDY, '"adc.reference" = { normal = "200 ppm", relative = true }', '"adc.reference" = { values = [5, -1] }'
    )
    text = changed(text, '{ uniform = "1 mV" }', "{ values = [1.0, 1e308] }")
    text = changed(
        text, '"sum.output ->', '"source.output -> sum.third", "source.output -> sum.fourth", "sum.output ->'
    )
    study = study_of(tmp_path / "study.toml", text)
    alone, together = run_study(study, engine="python"), run_study(study, engine="compiled", lanes=8)
    assert together.faults == alone.faults
    assert together.digest == alone.digest
    assert any("is not finite" in fault for fault in alone.faults.values())
    assert any("AnalogToDigital.reference" in fault for fault in alone.faults.values())
    assert np.isfinite(together["bias"]).any()


@pytest.mark.exhaustive
def test_a_parameter_that_a_start_needs_is_settled_before(tmp_path: Path) -> None:
    text = changed(STUDY, 'first",', 'first",\n    "source.output -> total.input",')
    text = changed(text, "[study]", 'total = { kind = "DiscreteIntegrator", initial = 2.0, input_unit = "V" }\n[study]')
    text = changed(text, "[blocks]", 'total = { signal = "total.output", statistic = "mean" }\n[blocks]')
    text = changed(
        text, "[study.sweep]", '"total.initial" = { uniform = 1.0 }\n"total.gain" = { uniform = 0.5 }\n[study.sweep]'
    )
    study = study_of(tmp_path / "study.toml", text)
    assert SensorRuns(study, "compiled", 8).together.compiled.settled == {"total"}
    assert run_study(study, engine="compiled", lanes=8).digest == run_study(study, engine="python").digest


@pytest.mark.parametrize(("ticks", "begun"), [(20, False), (21, True)])
def test_a_measure_has_a_value_once_it_has_begun(study: Study, ticks: int, begun: bool) -> None:
    """Both measures begin at 20 ms, with the tick of number 20."""
    sensors = side_by_side.SideBySide(plan(replace(study.graph, probes=())), 1, ticks, 8, ["source.value"])
    measured, able = sensors.measured({"source.value": np.full(8, 1.0)}, np.arange(8))
    assert able.all()
    assert np.isfinite(measured[:, 0]).all() == begun


def test_an_interruption_ends_them(study: Study) -> None:
    stop = threading.Event()
    stop.set()
    with pytest.raises(StoppedError):
        SensorRuns(study, "compiled", 8).runs([0, 1], stop)


@pytest.mark.parametrize(
    ("runs", "lanes"), [(1, 0), (3, 0), (4, 8), (32, 8), (63, 8), (64, 16), (127, 16), (128, 32), (10**6, 32)]
)
@pytest.mark.parametrize(("wide", "most"), [(False, 16), (True, 32)])
def test_lanes_are_filled_several_times(
    runs: int, lanes: int, wide: bool, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(side_by_side, "has_wide_vectors", lambda: wide)
    assert side_by_side.lanes_for(runs, 1000) == min(lanes, most)


@pytest.mark.parametrize(
    ("name", "lanes"),
    [("closed_loop_accelerometer", 32), ("self_calibration_population", 32), ("six_axis_imu", 16), ("imu_3dof", 16)],
)
def test_large_graphs_take_fewer_lanes(name: str, lanes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many as were fastest; sizes are those that the compiled lanes have, but for places of intermediate results."""
    monkeypatch.setattr(side_by_side, "has_wide_vectors", lambda: True)
    planned = plan(read_graph(library_file(f"{name}.toml")).changed(probes=()))
    size, made = bytes_of_a_run(planned), write_tick(planned, lanes=True)
    vectors = sum(length for _, length in dict(vectors_of(planned)).values())
    numbers = sum(made.constants.counts.values()) + sum(made.memory.counts.values()) + vectors
    assert 0.7 * 8 * numbers < size < 1.3 * 8 * numbers
    assert side_by_side.lanes_for(10_000, size) == lanes
    assert side_by_side.lanes_for(10_000, 1 << 20) == side_by_side.LEAST


def test_the_width_of_vectors_is_that_of_the_processor() -> None:
    """The flags that the kernel shows, where it shows them as this family of processors has them."""
    words = set(Path("/proc/cpuinfo").read_text(encoding="ascii").split()) if Path("/proc/cpuinfo").exists() else set()
    assert side_by_side.has_wide_vectors() == ("avx512f" in words)


FLICKER = """
name = "flicker"
rate = "1 kHz"
samples = 20
seed = 3
[blocks.noise]
kind = "FlickerNoise"
lowest_frequency = "1 Hz"
level = 0.1
[measures.last]
signal = "noise.value"
statistic = "last"
[study]
runs = 16
[study.spread]
"noise.lowest_frequency" = { uniform = "900 mHz" }
"""


@pytest.mark.exhaustive
@pytest.mark.defect(
    "C5",
    before="flicker noise of a spread band: an error inside proofmass in lanes, memory beyond its buffer alone",
    after="a sensor with buffers of another length has a loop of its own",
)
def test_sensors_whose_buffers_have_other_lengths(tmp_path: Path) -> None:
    study = study_of(tmp_path / "study.toml", FLICKER)
    alone = run_study(study, engine="python")
    assert len({study.blocks(study.drawn(number)[0])["noise"] for number in range(16)}) == 16
    assert len(set(alone["last"][:, 0].tolist())) == 16
    for lanes in (0, 8):
        assert run_study(study, engine="compiled", lanes=lanes).digest == alone.digest


@pytest.mark.exhaustive
def test_sensors_that_are_not_even_planned_fail_alone(tmp_path: Path) -> None:
    """What a start follows from is computed before sensors run together: of some it may not be."""
    text = changed(FLICKER, '{ uniform = "900 mHz" }', '{ values = ["1 Hz", "-1 Hz"] }')
    study = study_of(tmp_path / "study.toml", text)
    alone, together = run_study(study, engine="python"), run_study(study, engine="compiled", lanes=8)
    assert 0 < len(alone.faults) < 16
    assert together.faults == alone.faults
    assert together.digest == alone.digest
