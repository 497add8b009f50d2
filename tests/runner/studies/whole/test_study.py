"""Studies run: every order, chunk, interruption and engine gives the same bits, and a replay does too."""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.host.processors import processors
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.studies.kept.ledger import FILE, Ledger
from proofmass.runner.studies.outcome.outcomes import SensorRun, outcomes_of
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import replay, run_study
from tests.by_hand.study_texts import STUDY


@pytest.fixture
def study(tmp_path: Path) -> Study:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return read_study(path)


@pytest.mark.exhaustive
def test_one_digest_whatever_the_engine_the_order_and_the_chunks(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    python = run_study(study, engine="python")
    assert python.values["bias"].shape == (12, 3)
    assert not python.interrupted
    assert not python.faults
    assert run_study(study, engine="compiled").digest == python.digest
    for engine in ("python", "compiled"):
        sensors = SensorRuns(study, engine)
        for number in np.random.default_rng(5).permutation(12).tolist():
            values = [run.values for run in sensors.run(number)]
            assert values == list(zip(python["bias"][number], python["noise"][number], strict=True))
        monkeypatch.setattr("proofmass.runner.studies.runs.sensor_runs.CHUNK", 7)
    assert run_study(study, runs=2, folder=tmp_path / "a").digest != python.digest
    assert run_study(study, folder=tmp_path / "a").digest == python.digest
    assert run_study(study, seed=12).digest != python.digest


@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.friendly(34, "a replay has the same bits")
def test_a_replay_gives_the_traces_of_the_same_bits(study: Study, engine: EngineName) -> None:
    result = run_study(study, engine="python")
    again = replay(study, 7, 2, engine)
    assert {name: measure.value for name, measure in again.measures.items()} == {
        n: result[n][7, 2] for n in result.values
    }
    assert again["adc.code"].values[20:].std(ddof=1) == pytest.approx(result["noise"][7, 2], rel=1e-12)
    assert again.graph.blocks["adc"].reference == study.drawn(7)[2]["adc.reference"]  # type: ignore[attr-defined]
    with pytest.raises(ModelError, match="no such run"):
        replay(study, 12)
    with pytest.raises(ModelError, match="no such epoch"):
        replay(study, 0, 3)


def test_the_means_follow_the_parameters(study: Study) -> None:
    """The code of a volt is inversely proportional to the reference: the drift shows in the measures."""
    result = run_study(study.changed(runs=40, seed=3), engine="compiled")
    data = result.to_xarray()
    assert data["bias"].dims == ("run", "epoch")
    assert data["filter.corner_frequency"].values.tolist() == [100.0, 200.0] * 40
    assert data["age"].values.tolist() == list(study.epochs)
    drawn = np.array(
        [
            [at["source.value"] / at["adc.reference"] for at in study.changed(runs=40, seed=3).drawn(k)]
            for k in range(80)
        ]
    )
    error = result["bias"] / drawn / (result["bias"] / drawn).mean() - 1.0
    assert abs(error).max() < 0.05
    assert abs(np.corrcoef(error.ravel(), drawn.ravel())[0, 1]) < 0.3


def test_runs_that_fail_are_told_and_count_against_the_yield(study: Study) -> None:
    bad = Study(study.graph, runs=20, spread={"adc.reference": {"normal": "5 V"}}, limits={"bias": {"at_least": -1e9}})
    result = run_study(bad, engine="python")
    failed = {run for run, _ in result.faults}
    assert 0 < len(failed) < 20
    assert failed == {k for k in range(20) if bad.drawn(k)[0]["adc.reference"] <= 0.0}
    assert "AnalogToDigital.reference" in next(iter(result.faults.values()))
    assert result.yields() == {"bias": 1.0 - len(failed) / 20, "all limits": 1.0 - len(failed) / 20}
    assert np.isnan(result["bias"][min(failed)]).all()


def test_a_changed_graph_or_study_is_refused_with_what_changed(study: Study, tmp_path: Path) -> None:
    run_study(study, runs=1, engine="python", folder=tmp_path)
    for old, new, said in (
        ('reference = "5 V"', 'reference = "4 V"', 'reference = "4.0 V"'),
        ('uniform = "1 mV"', 'uniform = "2 mV"', "width=0.002"),
        ("seed = 11", "seed = 12", "+seed = 12"),
    ):
        path = tmp_path / "other.toml"
        path.write_text(STUDY.replace(old, new))
        with pytest.raises(ModelError, match="belongs to another") as caught:
            run_study(read_study(path), runs=1, engine="python", folder=tmp_path)
        assert said in caught.value.problems[0].got
    (tmp_path / FILE).write_bytes(b"no database at all, but long enough to look at" * 100)
    with pytest.raises(ModelError, match="is not the ledger"):
        run_study(study, runs=1, engine="python", folder=tmp_path)


@pytest.mark.defect("S933", before="numbers of other points of the sweep, without a word", after="another study")
def test_a_sweep_in_another_order_is_another_study(study: Study, tmp_path: Path) -> None:
    """The last parameter of a sweep moves fastest, so run 1 is another point."""
    swept = {"adc.reference": [4.0, 5.0], "source.value": [1.0, 2.0]}
    run_study(Study(study.graph, runs=1, sweep=swept), engine="python", folder=tmp_path)
    turned = Study(study.graph, runs=1, sweep=dict(reversed(swept.items())))
    with pytest.raises(ModelError, match="belongs to another study"):
        run_study(turned, engine="python", folder=tmp_path)


def test_the_ledger_keeps_every_bit(tmp_path: Path) -> None:
    values = (-0.0, 5e-324, 1.7976931348623157e308, 0.1, -3.0)
    names = [f"m{i}" for i in range(len(values))]
    for _ in range(2):
        ledger = Ledger(tmp_path / FILE, names, 1, {"graph": "a"})
        ledger.keep([outcomes_of([SensorRun(3, 0, values)], 1, len(values))])
        ledger.close()
    ledger = Ledger(tmp_path / FILE, names, 1, {"graph": "a"})
    kept = ledger.outcomes(10)
    ledger.close()
    assert kept.numbers.tolist() == [3]
    assert [v.hex() for v in kept.values[0, 0].tolist()] == [v.hex() for v in values]


def test_the_ledger_keeps_each_run_once_in_whatever_order(tmp_path: Path) -> None:
    dice = np.random.default_rng(2)
    ledger = Ledger(tmp_path / FILE, ["m"], 2, {"graph": "a"})
    for _ in range(60):
        some = dice.permutation(200)[: dice.integers(0, 40)].tolist()
        runs = [SensorRun(n, epoch, (n + 0.5 * epoch,)) for n in some for epoch in (0, 1)]
        runs = [run._replace(values=None, fault="lost") if run.run == 77 else run for run in runs]
        ledger.keep([outcomes_of(runs, 2, 1)])
    assert ledger.outcomes(1000).numbers.tolist() == list(range(200))
    kept = ledger.outcomes(150)
    assert kept.faults == {(77, 0): "lost", (77, 1): "lost"}
    expected = np.arange(150.0)[:, None] + [0.0, 0.5]
    expected[77] = np.nan
    assert np.array_equal(kept.values[:, :, 0], expected, equal_nan=True)
    ledger.close()


@pytest.mark.exhaustive  # five processes; tests/crash has two kills in every run of the tests
def test_killed_again_and_again_it_ends_with_the_same_bits(tmp_path: Path) -> None:
    """Killed without warning (signal 9) three times, interrupted (Ctrl-C) once, then left to end."""
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    folder = tmp_path / "out"
    command = [sys.executable, "-m", "proofmass", "montecarlo", str(path), "--runs", "150", "--engine", "python"]
    command += ["--out", str(folder)]
    expected = run_study(read_study(path), runs=150, engine="python").digest
    counts = [0]
    for number in (signal.SIGKILL, signal.SIGKILL, signal.SIGKILL, signal.SIGINT):
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ)
        _wait_for_more(folder / FILE, counts[-1], process)
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
        if process.returncode == 0:
            break  # it was faster than the signal
        assert process.returncode == (130 if number == signal.SIGINT else -number), said
        counts.append(_count(folder / FILE))
    assert counts == sorted(counts)
    assert len(counts) > 2, "nothing was killed on its way"
    result = run_study(read_study(path), runs=150, engine="python", folder=folder)
    assert result.digest == expected
    assert len(result.numbers) == 300


def _wait_for_more(path: Path, before: int, process: "subprocess.Popen[bytes]") -> None:
    for _ in range(3000):
        if process.poll() is not None or _count(path) > before:
            return
        time.sleep(0.02)
    raise AssertionError("nothing was written in a minute")


def _count(path: Path) -> int:
    if not path.exists():
        return 0
    data = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    try:
        return int(data.execute("SELECT TOTAL(runs) FROM stretches").fetchone()[0])
    except sqlite3.OperationalError:
        return 0
    finally:
        data.close()


def test_a_result_is_shown_in_a_line(study: Study) -> None:
    assert repr(run_study(study, runs=2, engine="python")) == (
        "<StudyResult of a converter that ages: 4 of 4 runs at 3 epochs; bias, noise>"
    )


@pytest.mark.parametrize(("count", "expected"), [(6, 6), (None, 1)])
def test_processors_where_the_system_does_not_say_which_are_allowed(
    count: int | None, expected: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on macOS: all that there are, or one."""
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: count)
    assert processors() == expected
