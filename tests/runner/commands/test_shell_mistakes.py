"""Mistakes at the shell: words of other tools, values without quotes, files of another kind."""

import shlex
from pathlib import Path

import pytest

from proofmass.runner.command_line import cli
from proofmass.runner.commands.misused import ELSEWHERE
from tests.runner.commands.test_user_errors import Command, command

__all__ = ["command"]  # the fixture

LOOP = "library:closed_loop_accelerometer"
ANSWERS = {  # a command line, and words of its answer
    "simulate loop.toml": "no such command: simulate; did you mean run?",
    "sim loop.toml": "did you mean run?",
    "bode loop.toml": "did you mean margins?",
    "init": "did you mean new?",
    "psd loop.toml": "did you mean spectrum?",
    "optimize loop.toml": "did you mean tune?",
    "help": "did you mean --help?",
    "run loop.toml --time 1s": "no such option: --time; did you mean --duration?",
    "run loop.toml --steps 5": "did you mean --samples?",
    "montecarlo loop.toml --jobs 2": "did you mean --threads?",
    "run loop.toml --sampels 5": "did you mean --samples?",
    "run loop.toml --duration 1 s": 'quote it: --duration "1 s"',
    "run --duration 1 s loop.toml": 'quote it: --duration "1 s"',
    "run loop.toml --set adc.bits 12": "write --set adc.bits=12",
    "run loop.toml --set adc.bits = 12": "write --set adc.bits=12",
    "run loop.toml --set adc.bits= 12": "write --set adc.bits=12",
    "run loop.toml --set sensor.mass=50 ug": 'quote it: --set "sensor.mass=50 ug"',
    "run loop.toml --set bits=12": "for example adc.bits=12",
    "spectrum loop.toml --band 1 Hz 100 Hz": 'quote it: --band "1 Hz" "100 Hz"',
    "check .": ". is a folder; did you mean ./loop.toml?",
    "check empty": "empty is a folder; name a file in it",
    "check notes.txt": "notes.txt:1: this is not a graph file: it is not TOML\n  hint:     did you mean loop.toml?",
    "check lop": "did you mean loop.toml?",
    "run closed_loop_acelerometer": f"did you mean {LOOP}?",
    "run loop.toml --out notes.txt": "notes.txt is a file; name a folder",
    f"margins {LOOP} --loop dac.voltag": "--loop dac.voltag: dac.voltag is not an output",
    "noise loop.toml --output adc.numbr": "--output adc.numbr: adc.numbr is not an output",
    "response loop.toml --input acceleration.output": "write it by its place: proofmass response GRAPH INPUT OUTPUT",
    "response loop.toml acceleration.out adc.code": "INPUT acceleration.out: acceleration.out is not an output",
}


@pytest.mark.exhaustive(but=14)
@pytest.mark.parametrize("line", ANSWERS)
@pytest.mark.friendly(7, "mistakes at the shell are answered by their cure")
def test_a_mistake_is_answered_by_its_cure(line: str, command: Command) -> None:
    assert command("new", "loop.toml").code == 0
    Path("notes.txt").write_text("This is a note.\n", encoding="utf-8")
    Path("empty").mkdir()
    answer = command(*shlex.split(line))
    assert answer.code in (1, 2)
    assert answer.out == ""
    assert ANSWERS[line] in answer.err


def test_words_of_other_tools_are_none_of_ours() -> None:
    options = {name for one in cli.commands.values() for param in one.params for name in param.opts}
    assert set(ELSEWHERE) <= {*cli.commands, *options, "--help", "--version"}
    words = [word for others in ELSEWHERE.values() for word in others]
    assert not {word for word in words if not word.startswith("--")} & {*cli.commands}


def test_a_file_too_many_is_no_missing_quote(command: Command) -> None:
    answer = command("run", "loop.toml", "--seed", "1", "other.toml")
    assert answer.err.endswith("Error: Got unexpected extra argument (other.toml)\n")


@pytest.mark.parametrize(
    ("words", "names"),
    [
        (("gallery", "gyroscope"), ("closed_loop_gyroscope", "gyroscope_axis", "fibre_optic_gyroscope")),
        (("gallery", "seismometer"), ("force_balance_seismometer",)),
        (("blocks", "geophone"), ("MassSpringDamper",)),
        (("blocks", "seismometer"), ("MassSpringDamper",)),
        (("blocks", "johnson noise"), ("WhiteNoise",)),
        (("blocks", "--find", "geophone"), ("MassSpringDamper",)),
    ],
)
@pytest.mark.friendly(11, "a word that is no name lists what contains it")
def test_a_word_lists_what_contains_it(words: tuple[str, ...], names: tuple[str, ...], command: Command) -> None:
    answer = command(*words)
    assert answer.code == 0
    assert not [name for name in names if name not in answer.out]
