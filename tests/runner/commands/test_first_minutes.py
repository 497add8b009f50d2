"""What the first minutes with the package take, of a processor, with nothing compiled; and what they find."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from tests.runner.commands.test_user_errors import Command, command

__all__ = ["command"]  # the fixture


def processor_seconds(folder: Path, *words: str) -> float:
    """Run a command from a folder with an empty cache, and return what it took."""
    environment = os.environ | {"PROOFMASS_CACHE": str(folder / "cache"), "OPENBLAS_NUM_THREADS": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-m", "proofmass", *words], cwd=folder, env=environment, check=True, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.exhaustive
@pytest.mark.friendly(3, "a report within ten seconds of a processor, with an empty cache")
def test_a_first_report_takes_seconds(tmp_path: Path) -> None:
    assert processor_seconds(tmp_path, "run", "library:closed_loop_accelerometer", "--out", "results") < 10.0
    assert (tmp_path / "results" / "report.html").stat().st_size > 10_000


@pytest.mark.exhaustive
@pytest.mark.friendly(4, "help within half a second of a processor")
def test_help_is_there_at_once(tmp_path: Path) -> None:
    assert min(processor_seconds(tmp_path, "run", "--help") for _ in range(2)) < 0.5


@pytest.mark.friendly(6, "an unknown kind hides no other fault")
def test_a_kind_that_is_unknown_hides_no_fault_of_another_block(command: Command) -> None:
    Path("m.toml").write_text(
        'name = "m"\nrate = "1 kHz"\nwires = ["b.output -> c.forc"]\nprobes = ["c.displacement"]\n'
        '[blocks.b]\nkind = "Stepp"\n[blocks.c]\nkind = "MassSpringDamper"\nmass = "20 ugg"\n'
    )
    answer = command("check", "m.toml")
    assert answer.code == 1
    for words in ("did you mean force?", "did you mean Step?", "did you mean ug?", "3 problems in m.toml"):
        assert words in answer.err


@pytest.mark.parametrize(
    ("unit", "right"),
    [("Nr/m", "N/m"), ("gu", "g0"), ("kgg", "kg"), ("mss", "ms"), ("Vv", "V"), ("rads", "rad"), ("Hzz", "Hz")],
)
@pytest.mark.friendly(8, "misspelt units")
def test_a_misspelt_unit_is_answered_by_one_of_the_dimension(unit: str, right: str, command: Command) -> None:
    places = {
        "N/m": 'kind = "MassSpringDamper"\nstiffness',
        "g0": 'kind = "Constant"\nunit = "m/s^2"\nvalue',
        "kg": 'kind = "MassSpringDamper"\nmass',
        "ms": 'kind = "Step"\nstart_time',
        "V": 'kind = "AnalogToDigital"\nreference',
        "rad": 'kind = "Sine"\nphase',
        "Hz": 'kind = "Sine"\nfrequency',
    }
    Path("m.toml").write_text(f'name = "m"\nrate = "1 kHz"\n[blocks.b]\n{places[right]} = "3 {unit}"\n')
    assert f"did you mean {right}?" in command("check", "m.toml").err
