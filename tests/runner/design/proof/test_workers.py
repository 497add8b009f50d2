"""Proofs in several processes: the same certificates, whatever ends a process, and none where that is not worth it."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.design.proof import search
from proofmass.runner.design.proof.attempt import Attempt
from proofmass.runner.design.proof.look import BoxLook
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.host.forked import Forked, can_fork
from proofmass.runner.host.processors import processors
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.runner.design.proof.test_prove import GRAPH, status

Patch = pytest.MonkeyPatch
pytestmark = pytest.mark.skipif(not can_fork(), reason="there is no fork")
HERE = os.getpid()


@pytest.fixture(autouse=True)
def at_once(monkeypatch: Patch) -> Iterator[None]:
    """Processes are started for the second box, and none of them is left."""
    before = children()
    monkeypatch.setattr(search, "WORTH_SECONDS", -1.0)
    yield
    assert children() <= before


def proofs(workers: int, **more: Any) -> Proofs:
    """A delay margin of 61 % of its closed form takes 8 boxes; a gain margin fails for some sensors."""
    given: dict[str, Any] = {"gain_margin": "26 dB", "delay_margin": "7 ms", "seconds": 60.0} | more
    return prove(GRAPH, tolerances={"gain.gain": "10 %", "hold.gain": "20 %"}, workers=workers, **given)


@pytest.fixture(scope="module")
def alone() -> Proofs:
    found = proofs(1)
    assert sum(one.searched.boxes for one in found.proofs) > 10
    return found


def data_of(found: Proofs) -> Any:
    """All that is known, without times."""
    return [{key: value for key, value in one.as_data().items() if key != "seconds"} for one in found.proofs]


def children() -> set[int]:
    """The processes of this one."""
    return set(map(int, Path(f"/proc/self/task/{os.getpid()}/children").read_text(encoding="utf-8").split()))


@contextlib.contextmanager
def in_children(monkeypatch: Patch, act: Any) -> Iterator[None]:
    """Let something happen in other processes before they look at a box."""
    at = BoxLook.at

    def acted(look: BoxLook, box: Any, start: Any) -> Any:
        if os.getpid() != HERE:
            act(box)
        return at(look, box, start)

    with monkeypatch.context() as patched:
        patched.setattr(BoxLook, "at", acted)
        yield


@pytest.mark.exhaustive("3")
@pytest.mark.parametrize("workers", [2, 3])
def test_answers_and_certificates_are_those_of_one_process(workers: int, alone: Proofs, monkeypatch: Patch) -> None:
    def too_many(*arguments: object) -> None:
        raise AssertionError

    before = children()
    with in_children(monkeypatch, lambda box: None):
        found = proofs(workers)
    assert data_of(found) == data_of(alone)
    assert certificate(found) == certificate(alone)
    assert check_certificate(certificate(found))
    assert "refuted" in status(found)
    assert children() <= before


@pytest.mark.exhaustive
def test_boxes_are_looked_at_in_other_processes(tmp_path: Path, monkeypatch: Patch) -> None:
    with in_children(monkeypatch, lambda box: (tmp_path / str(os.getpid())).touch()):
        proofs(2)
    assert len(list(tmp_path.iterdir())) == 2
    assert str(HERE) not in {file.name for file in tmp_path.iterdir()}


@pytest.mark.exhaustive("every box")
@pytest.mark.parametrize("dying", ["the first box", "every box"])
def test_what_a_process_leaves_others_do(dying: str, alone: Proofs, tmp_path: Path, monkeypatch: Patch) -> None:
    def dies(box: Any) -> None:
        with contextlib.suppress(FileExistsError):
            (tmp_path / "died").touch(exist_ok=dying == "every box")
            os.kill(os.getpid(), signal.SIGKILL)

    with in_children(monkeypatch, dies):
        found = proofs(2)
    assert certificate(found) == certificate(alone)
    assert data_of(found) == data_of(alone)
    lost = 1 if dying == "the first box" else 2
    assert found.lost_workers == found.as_data()["lost_workers"] == lost
    assert f"{lost} worker{'s' * (lost > 1)} ended early; others did their part" in proofs_text(found)
    assert "lost_workers" not in alone.as_data()


@pytest.mark.exhaustive
def test_an_exception_in_a_process_is_met_here_in_its_turn(alone: Proofs, monkeypatch: Patch) -> None:
    def raises(box: Any) -> None:
        raise ZeroDivisionError

    with in_children(monkeypatch, raises):
        assert certificate(proofs(2)) == certificate(alone)

    def raises_everywhere(*arguments: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(Attempt, "look", raises_everywhere)
    with pytest.raises(ZeroDivisionError):
        proofs(2)


@pytest.mark.exhaustive
def test_a_process_that_hangs_does_not_hang_the_search(monkeypatch: Patch) -> None:
    begin = time.monotonic()
    with in_children(monkeypatch, lambda box: time.sleep(600.0)):
        found = proofs(2, gain_margin="", delay_margin="10.5 ms", seconds=2.0)
    assert time.monotonic() - begin < 20.0
    assert found.proofs[-1].searched.why == "the time is up"


def test_ctrl_c_keeps_what_is_proved(monkeypatch: Patch) -> None:
    def slows(box: Any) -> None:
        time.sleep(0.5)

    pressed = threading.Timer(2.5, os.kill, (os.getpid(), signal.SIGINT))
    pressed.start()
    with in_children(monkeypatch, slows):
        found = proofs(2, gain_margin="", delay_margin="10.5 ms")
    pressed.join()
    assert found.interrupted
    assert found.proofs[0].status == "proved"
    assert found.proofs[-1].status == "open"
    assert check_certificate(certificate(found))


PROGRAM = """
import os, time
from proofmass.runner.design.proof import search
from proofmass.runner.design.proof.look import BoxLook
from tests.runner.design.proof.test_prove import GRAPH
from proofmass import prove
at, here = BoxLook.at, os.getpid()
def slow(look, box, start):
    if os.getpid() != here:
        os.write(1, f"{os.getpid()}\\n".encode())  # in one piece
        time.sleep(0.2)
    return at(look, box, start)
BoxLook.at, search.WORTH_SECONDS = slow, -1.0
prove(GRAPH, tolerances={"gain.gain": "10 %"}, delay_margin="10.5 ms", workers=2)
"""


@pytest.mark.exhaustive
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_processes_end_with_the_one_that_started_them(number: signal.Signals) -> None:
    program = subprocess.Popen([sys.executable, "-c", PROGRAM], stdout=subprocess.PIPE, text=True)
    assert program.stdout is not None
    others = {int(program.stdout.readline()) for _ in range(2)}
    program.send_signal(number)
    program.stdout.close()
    assert program.wait(timeout=60) in (0, -signal.SIGKILL)
    for _ in range(200):
        if not any(Path(f"/proc/{other}").exists() for other in others):
            return
        time.sleep(0.5)
    pytest.fail("a process goes on")


def test_a_short_proof_starts_no_process(monkeypatch: Patch) -> None:
    monkeypatch.undo()
    monkeypatch.setattr(search, "Forked", lambda *given: pytest.fail("processes for less than a second"))
    graph = read_graph("library:closed_loop_accelerometer")
    assert prove(graph, tolerances={"torquer.gain": "10 %"}, workers=8).proved


@pytest.mark.exhaustive
def test_one_process_starts_no_other(monkeypatch: Patch) -> None:
    monkeypatch.setattr(search, "Forked", lambda *given: pytest.fail("a process beside one"))
    proofs(1)
    monkeypatch.setattr("proofmass.runner.design.proof.prove.processors", lambda: 1)
    prove(GRAPH, tolerances={"gain.gain": "10 %"}, delay_margin="10.5 ms")


@pytest.mark.exhaustive
def test_a_process_of_a_pool_starts_none(monkeypatch: Patch, alone: Proofs) -> None:
    monkeypatch.setattr("proofmass.runner.host.forked.can_fork", lambda: False)
    assert certificate(proofs(2)) == certificate(alone)
    assert Forked(int, 3).count == 0


@pytest.mark.exhaustive
def test_the_command_takes_a_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["prove", "library:closed_loop_accelerometer", "--tolerance", "torquer.gain=10 %"]
    files = [str(tmp_path / f"{count}.json") for count in (1, 2)]
    for count, file in enumerate(files, start=1):
        assert main([*words, "--workers", str(count), "--out", file]) == 0
    assert Path(files[0]).read_bytes() == Path(files[1]).read_bytes()
    assert main([*words, "--workers", "0"]) == 2
    assert main([*words, "--threads", "2"]) == 2
    assert "did you mean --workers?" in capsys.readouterr().err


def test_processors_are_those_that_this_process_may_use() -> None:
    may = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(may)})
        assert processors() == 1
    finally:
        os.sched_setaffinity(0, may)
    assert processors() == len(may)
