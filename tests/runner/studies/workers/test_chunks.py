"""Runs on Dask workers: the bits of those here, whatever becomes of workers, scheduler and Ctrl-C."""

import contextlib
import multiprocessing
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from distributed import KilledWorker, LocalCluster

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.command_line import main
from proofmass.runner.run.faults import RunError
from proofmass.runner.studies.kept.ledger import FILE
from proofmass.runner.studies.outcome.running_means import RunningMeans
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.shown.text import study_text
from proofmass.runner.studies.whole import study as whole
from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.studies.workers import chunks, cluster
from proofmass.runner.studies.workers.chunks import chunk_size, runs_on_workers
from proofmass.runner.studies.workers.parcel import Parcel
from proofmass.runner.studies.workers.worker import run_chunk
from tests.by_hand.design_texts import INTEGRATING
from tests.by_hand.kept_runs import kept
from tests.by_hand.study_texts import RECORDED, RECORDING, STUDY, TRIPLE


@pytest.fixture(scope="module")
def workers() -> Iterator[Any]:
    """Two workers."""
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as made:
        yield made


@pytest.fixture
def address(workers: Any) -> str:
    return str(workers.scheduler_address)


@pytest.fixture
def study(tmp_path: Path) -> Study:
    (tmp_path / "study.toml").write_text(STUDY)
    return read_study(tmp_path / "study.toml")


def own_study(folder: Path) -> Study:
    """A study with a recording and a block of its own."""
    (folder / "data").mkdir(exist_ok=True)
    (folder / "data" / "source.csv").write_text(RECORDING)
    (folder / "triple.py").write_text(TRIPLE)
    (folder / "study.toml").write_text(RECORDED)
    return read_study(folder / "study.toml", load_own_blocks(folder / "triple.py"))


@pytest.mark.exhaustive("python")
@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.friendly(35, "workers of Dask give one digest")
def test_one_digest(engine: Any, study: Study, address: str, tmp_path: Path) -> None:
    expected = run_study(study, engine="python", folder=tmp_path / "here")
    made = run_study(study, engine=engine, lanes=8, dask=address, folder=tmp_path / "there")
    assert made.digest == expected.digest
    assert kept(tmp_path / "there" / FILE) == kept(tmp_path / "here" / FILE)
    run_study(study, engine="python", dask="tcp://127.0.0.1:1", folder=tmp_path / "there")  # nothing is left to do


@pytest.mark.exhaustive
@pytest.mark.parametrize(("runs", "times"), [(12, 1), pytest.param(400, 3, marks=pytest.mark.exhaustive)])
def test_one_digest_of_margins(runs: int, times: int, address: str) -> None:
    """Also when threads compute the margins of neighbours at the same time."""
    graph = read_graph_text(INTEGRATING).changed(samples=100, duration=None, probes=())
    study = Study(graph, runs=runs, margins="0 s", spread={"plant.gain": {"normal": "5 %", "relative": True}})
    expected = run_study(study, engine="python", threads=1).digest
    ways: list[dict[str, Any]] = [{"threads": threads, "lanes": lanes} for threads in (1, 2, 8) for lanes in (0, 8)]
    for way in [*ways, {"dask": address, "lanes": 0}, {"dask": address, "lanes": 8}] * times:
        assert run_study(study, engine="compiled", **way).digest == expected, way


def test_failures_have_the_same_words(study: Study, address: str, tmp_path: Path) -> None:
    spread = {"adc.reference": {"values": [5, -1]}, "source.value": {"values": [1, 1e308]}}
    bad = Study(study.graph, runs=12, spread=spread)
    expected = run_study(bad, engine="python", folder=tmp_path / "here")
    assert len(expected.faults) > 3
    assert run_study(bad, engine="python", dask=address, folder=tmp_path / "there").faults == expected.faults


def test_recordings_and_own_blocks_go_along(address: str, tmp_path: Path) -> None:
    study = own_study(tmp_path)
    expected = run_study(study, engine="python")
    assert run_study(study, engine="python", dask=address).digest == expected.digest


class Perilous:
    """As much of a client as chunks need; a worker dies of some runs, and all that waits behind them goes down too."""

    def __init__(self, deadly: set[int]) -> None:
        self.deadly, self.under_way, self.counted = deadly, list[Doomed](), 0

    def nthreads(self) -> dict[str, int]:
        self.counted += 1
        return {"worker": 2}

    def submit(self, function: Any, *given: Any, pure: bool) -> Any:
        self.under_way.append(Doomed(self, *given))
        return self.under_way[-1]

    def cancel(self, futures: list[Any]) -> None:
        self.under_way.clear()


class Doomed:
    """A chunk on its way through them."""

    def __init__(self, client: Perilous, parcel: Parcel, numbers: tuple[int, ...]) -> None:
        self.client, self.parcel, self.numbers = client, parcel, numbers

    def done(self) -> bool:
        return True

    def result(self) -> Any:
        beside = {number for other in self.client.under_way for number in other.numbers}
        self.client.under_way.remove(self)
        if beside & self.client.deadly:
            raise KilledWorker("run_chunk", SimpleNamespace(address="tcp://there"), 3)  # type: ignore[arg-type]
        return run_chunk(self.parcel, self.numbers)


@pytest.mark.parametrize("deadly", [set(), {7}, {0, 5, 11}])
def test_runs_that_kill_workers_are_named(deadly: set[int], study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not those that waited behind them, which are tried again alone; where all others are done, it is said."""
    client = Perilous(deadly)
    monkeypatch.setattr(chunks, "connected", lambda _: contextlib.nullcontext(client))
    monkeypatch.setattr(chunks, "COUNTS", 60.0)
    monkeypatch.setattr(chunks, "chunk_size", lambda *_: 1)
    sensors, left = SensorRuns(study, "python"), np.arange(12)
    arriving = runs_on_workers("", sensors, [], left, RunningMeans(study, sensors.measures), threading.Event())
    arrived = list[int]()
    if not deadly:
        assert sorted(number for some in arriving for number in some.numbers.tolist()) == left.tolist()
        assert client.counted == 2, "as it begins, and as it ends"
        return
    with pytest.raises(RunError, match=r"workers die as they begin with run \d+") as caught:
        arrived.extend(number for some in arriving for number in some.numbers.tolist())
    assert int(caught.value.problem.hint.rpartition(" ")[2]) in deadly
    assert len(set(arrived)) == len(arrived)
    assert not set(arrived) & deadly
    if len(deadly) == 1:
        assert len(arrived) > 4


@pytest.mark.exhaustive
def test_workers_may_come_late(study: Study) -> None:
    """The first chunks arrive before any worker has been counted."""
    with LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address="127.0.0.1:0") as made:
        starter = threading.Timer(0.5, made.scale, (1,))
        starter.start()
        result = run_study(study, engine="python", dask=made.scheduler_address)
        starter.join()
    assert result.digest == run_study(study, engine="python").digest


@pytest.mark.exhaustive
def test_a_study_that_may_stop_stops_after_the_same_run(address: str, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY.replace("runs = 6", "runs = 500") + "\n[study.stop]\nbias = 1.0\n")
    study = read_study(tmp_path / "study.toml")
    expected = run_study(study, engine="python")
    made = run_study(study, engine="python", dask=address)
    assert made.planned_runs == expected.planned_runs < 1000
    assert made.digest == expected.digest


def test_an_interruption_keeps_what_has_arrived(study: Study, address: str, tmp_path: Path) -> None:
    sensors, interrupted = SensorRuns(study, "python"), threading.Event()
    arriving = runs_on_workers(
        address, sensors, [], np.arange(10**6), RunningMeans(study, sensors.measures), interrupted
    )
    first = next(arriving)
    assert (first.values == sensors.runs(first.numbers, interrupted).values).all()
    interrupted.set()
    began = time.monotonic()
    assert len(list(arriving)) < 10
    assert time.monotonic() - began < 30.0


@pytest.mark.exhaustive
def test_a_scheduler_that_goes_away(study: Study) -> None:
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as made:
        sensors = SensorRuns(study, "python")
        means = RunningMeans(study, sensors.measures)
        arriving = runs_on_workers(made.scheduler_address, sensors, [], np.arange(10**6), means, threading.Event())
        next(arriving)
    with pytest.raises(RunError, match="the same command goes on"):
        list(arriving)


@pytest.mark.exhaustive
def test_no_workers(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "NO_WORKER_SECONDS", 0.5)
    with (
        LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as made,
        pytest.raises(RunError, match="has had no workers") as caught,
    ):
        run_study(study, engine="python", dask=made.scheduler_address)
    assert "run 0" in caught.value.problem.got


@pytest.mark.exhaustive
def test_places_where_no_scheduler_is(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        with pytest.raises(RunError, match="no Dask scheduler answers") as caught:
            run_study(study, engine="python", dask=f"tcp://127.0.0.1:{port}")
    with pytest.raises(RunError, match="no Dask scheduler answers") as caught:
        run_study(study, engine="python", dask=f"127.0.0.1:{port}")
    assert "dask scheduler" in caught.value.problem.hint


@pytest.mark.parametrize("where", ["nonsense", "local:", "local:0", "local:x", "local:9999", "http://127.0.0.1:80", ""])
def test_what_is_no_cluster(where: str, study: Study) -> None:
    with pytest.raises(ModelError, match="is not a cluster"):
        run_study(study, engine="python", dask=where)


def test_without_dask(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(RunError, match="Dask is not installed") as caught:
        run_study(study, engine="python", dask="local")
    assert caught.value.problem.hint == 'pip install "proofmass[dask]"'


@pytest.mark.exhaustive
def test_chunks_take_a_quarter_of_a_second() -> None:
    """Whatever the first one took, in whole rows of lanes; never more than eight times the runs before."""
    for lanes in (0, 8, 64):
        size, each = max(1, lanes), 1e-3
        for _ in range(6):
            size = chunk_size(size, size * each, lanes)
        assert size % max(1, lanes) == 0
        assert 0.1 <= size * each <= 0.4
    assert chunk_size(64, 1000.0, 64) == 64
    assert chunk_size(64, 1e-9, 64) == 512


@pytest.mark.exhaustive
@pytest.mark.friendly(35, "workers of this machine by one option")
def test_workers_of_this_machine(study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["montecarlo", str(tmp_path / "study.toml"), "--engine", "python", "--json"]
    assert main([*command, "--dask", "local:1", "--threads", "2"]) == 2
    capsys.readouterr()
    assert main([*command, "--dask", "local:1"]) == 0
    assert run_study(study, engine="python").digest in capsys.readouterr().out


@pytest.mark.exhaustive
@pytest.mark.defect("C441", before="a worker that died was replaced without a word", after="it is named")
def test_a_local_worker_that_dies_is_replaced_and_named(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole, "BATCH_SECONDS", 0.0)
    others, killed = multiprocessing.active_children(), list[Any]()

    def kill(done: int, total: int, note: str) -> None:
        for process in [] if killed else set(multiprocessing.active_children()) - set(others):
            process.kill()
            killed.append(process)

    expected = run_study(study, runs=12, engine="python", threads=1)
    result = run_study(study, runs=12, engine="python", dask="local:1", progress=kill)
    assert result.digest == expected.digest
    (address,) = result.lost_workers
    assert f"the worker {address} ended early; others did its runs" in study_text(result)
