"""Damaged copies of the library: what `check` passes, a run of a few ticks does not refuse.

A number that stops being finite, or a block that fails in a tick, is no refusal: it follows from the run alone.
"""

import random
import shutil
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_files
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.tuning.check_file import check_file
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.ready import MANY_STEPS, unready
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.graph_texts import LIBRARY
from tests.hostile.test_mutations import DAMAGES, end_cut_off

COPIES = 100  # of each kind of damage
TICKS = 3
SECONDS = 5.0  # for one of them
HUGE = [b'"1.7976931348623157e308"', b'"1e-300"', b"1e300", b"-1e300", b"1e-30", b"65", b"1000000000", b"0.0"]


def number_changed(data: bytes, draw: random.Random) -> bytes:
    """A number with its unit, far off."""
    lines = data.split(b"\n")
    at = draw.choice([number for number, line in enumerate(lines) if b'= "' in line and b" " in line])
    head, _, tail = lines[at].partition(b'= "')
    unit = tail.partition(b'"')[0].partition(b" ")[2]
    value = draw.choice(HUGE).strip(b'"')
    lines[at] = head + b'= "' + value + (b" " + unit if unit else b"") + b'"'
    return b"\n".join(lines)


@pytest.mark.exhaustive(but=1)
@pytest.mark.defect("F7", before="ready to run; the run then refuses", after="what check passes, a run takes")
@pytest.mark.parametrize("damage", [*DAMAGES, number_changed], ids=lambda damage: damage.__name__)
def test_what_check_passes_a_run_does_not_refuse(
    damage: Callable[[bytes, random.Random], bytes], tmp_path: Path
) -> None:
    for path in library_files().values():
        shutil.copy(path, tmp_path)
    passed = 0
    for seed in range(COPIES):
        draw = random.Random(f"{damage.__name__} {seed}")
        file = tmp_path / "damaged.toml"
        file.write_bytes(damage(draw.choice(LIBRARY).read_bytes(), draw))
        began = time.thread_time()
        read, problems, study = check_file(file)
        if read is None or any(not problem.note for problem in problems) or not runs_alone(flatten(read)):
            continue
        refused = any(not problem.note for problem in unready(read, study))
        passed += not refused
        with suppress(RunError), pytest.raises(ModelError) if refused else nullcontext():
            if refused and study is not None:
                run_study(study, runs=1, engine="python")
            elif refused:
                plan(read).ticks()
            elif all(solver.substeps < MANY_STEPS for solver in plan(read).solvers):  # of others check has a note
                simulate(read, samples=TICKS, engine="python")
        assert time.thread_time() - began < SECONDS, seed
    assert passed >= (0 if damage is end_cut_off else 1)


SELF_TEST = """\
name = "a mass that is shaken"
rate = "10 kHz"
samples = 20
wires = ["shaker.output -> drive.force", "drive.displacement -> spring.input", "spring.output -> sense.force"]
probes = ["sense.displacement"]
[integration]
method = "runge_kutta_4"
[blocks]
shaker = { kind = "Constant", value = "AMPLITUDE", unit = "N" }
drive = { kind = "MassSpringDamper", damping = "DAMPING" }
spring = { kind = "Gain", gain = "1 N/m", input_unit = "m", output_unit = "N" }
sense = { kind = "MassSpringDamper" }
"""


@pytest.mark.defect("F8", before="30 s in one tick, then an error", after="stops in the step where numbers end")
def test_steps_end_where_numbers_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An amplitude at the end of the numbers, and a damping that asks for 100,000 steps a tick."""
    path = tmp_path / "shaken.toml"
    path.write_text(SELF_TEST.replace("AMPLITUDE", "1.7e308 N").replace("DAMPING", "1 kg/s"))
    assert main(["check", str(path)]) == 0
    assert "steps of runge_kutta_4" in capsys.readouterr().out
    began = time.thread_time()
    assert main(["run", str(path), "--quiet", "--engine", "python", "--samples", "2"]) == 3
    assert time.thread_time() - began < SECONDS
    assert "is not finite in tick 0" in capsys.readouterr().err


@pytest.mark.defect("F8", before="a million steps a tick without a word", after="a note of check says how many")
def test_many_steps_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = """\
rate = "1 kHz"
samples = 20
wires = ["f.output -> m.force"]
probes = ["m.displacement"]
integration = { method = "runge_kutta_4", substeps = SUBSTEPS }
[blocks]
f = { kind = "Step", amplitude = "1 uN", unit = "N" }
m = { kind = "MassSpringDamper" }
"""
    path = tmp_path / "substeps.toml"
    path.write_text(text.replace("SUBSTEPS", "1000000"))
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    assert "note: blocks.m: m: a tick takes 1,000,000 steps of runge_kutta_4" in said
    assert "20,000,000 in the run" in said
    path.write_text(text.replace("SUBSTEPS", "1000000000"))
    for command in ("check", "run"):
        assert main([command, str(path)]) == 1
        assert "integration.substeps: must be an integer within its bounds" in capsys.readouterr().err
