"""`check` means ready: what a run refuses because of what its files say, `check` refuses, and in the same words."""

from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, check, simulate
from proofmass.blocks import Constant, RecordedSignal
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.command_line import main
from proofmass.runner.studies.runs.notes import study_notes
from tests.by_hand.graph_texts import changed

RECORDED = """\
name = "recorded acceleration"
rate = "1 kHz"
duration = "20 ms"
wires = ["motion.output -> gain.input"]
probes = ["gain.output"]

[blocks]
motion = { kind = "RecordedSignal", file = "log.csv", column = "a", unit = "m/s^2" }
gain = { kind = "Gain", input_unit = "m/s^2" }
"""
GOOD = "time [s],a [m/s^2],b\n" + "".join(f"{n / 100},{n},{-n}\n" for n in range(10))
MEASURED = """\
name = "measured"
rate = "1 kHz"
duration = "20 ms"
[measures]
level = { signal = "source.output", statistic = "mean" }
[blocks]
source = { kind = "Constant" }
"""
PENDULUM = """\
name = "two stops"
rate = "10 kHz"
samples = 20
wires = ["push.output -> mass.force"]
probes = ["mass.displacement"]
[integration]
method = "auto"
[blocks]
push = { kind = "Constant", unit = "N" }
mass = { kind = "MassBetweenStops" }
"""


def answers(tmp_path: Path, capsys: pytest.CaptureFixture[str], *commands: str) -> list[tuple[int, str]]:
    """Exit code and all that is said by commands on the file that is there."""
    found = []
    for command in commands:
        code = main([command, str(tmp_path / "model.toml"), *(["--quiet"] if command != "check" else [])])
        said = capsys.readouterr()
        found.append((code, said.out + said.err))
    return found


RECORDINGS = {
    "missing": (None, "there is no such file"),
    "empty": ("", "needs a row of column names"),
    "only a head": ("time,a\n", "holds no rows"),
    "no head": ("0,1\n1,2\n", "needs a row of column names"),
    "no column": ("time,c\n0,1\n", "there is no column 'a'"),
    "two columns": ("time,a,a\n0,1,2\n", "has 2 columns 'a'"),
    "unit": ("time [s],a [V]\n0,1\n", "column a is in V"),
    "unknown unit": ("time [s],a [quux]\n0,1\n", "unknown unit"),
    "nan": ("time,a\n0,nan\n", "not a finite number"),
    "inf": ("time,a\n0,inf\n", "not a finite number"),
    "text": ("time,a\n0,off\n", "not a finite number"),
    "not available": ("time,a\n0,NA\n", "not a finite number"),
    "dates": ("time,a\n2024-05-01T12:00:00,1\n", "not a finite number"),
    "stamps": ("time,a\n1700000000,1\n1700000001,1\n", "looks like a date"),
    "backwards": ("time,a\n0,1\n2,1\n1,1\n", "its time does not grow"),
    "twice": ("time,a\n0,1\n0,1\n", "its time does not grow"),
    "semicolons": ("time;a\n0;1\n", "separate the columns by commas"),
    "tabs": ("time\ta\n0\t1\n", "needs a row of column names"),
    "short": ("time,a\n0,1\n1\n", "has 1 cells where the head has 2"),
    "latin": ("time,a\n0,1\n# gr\xf6\xdfe\n".encode("latin-1"), "cannot be read"),
}


@pytest.mark.defect("F7", before="ready to run; the run then refuses", after="check refuses in the same words")
@pytest.mark.parametrize(("content", "said"), RECORDINGS.values(), ids=RECORDINGS)
def test_a_recording_that_cannot_be_played(
    content: str | bytes | None, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "model.toml").write_text(RECORDED)
    if content is not None:
        (tmp_path / "log.csv").write_bytes(content.encode() if isinstance(content, str) else content)
    (checked, why), (ran, refused) = answers(tmp_path, capsys, "check", "run")
    assert (checked, ran) == (1, 1)
    assert said in why
    assert why.splitlines()[:-1] == refused.splitlines()[:-1]  # but for the line that counts them


@pytest.mark.parametrize("content", [GOOD, "\ufeff" + GOOD, GOOD.replace(",", ", "), "# by hand\n\n" + GOOD])
def test_a_recording_that_can_be_played(content: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "model.toml").write_text(RECORDED)
    (tmp_path / "log.csv").write_text(content)
    (checked, said), (ran, _) = answers(tmp_path, capsys, "check", "run")
    assert (checked, ran) == (0, 0)
    assert "note" not in said


NOTES = {
    "gap": (
        "time,a\n" + "".join(f"{n / 1000},{n}\n" for n in range(40) if not 20 <= n < 30),
        "the recording has a gap from 0.019 to 0.03 s, where 0.001 s lie between other values: it is bridged",
    ),
    "two gaps": (
        "time,a\n" + "".join(f"{n / 1000},{n}\n" for n in range(60) if not 20 <= n < 30 and not 40 <= n < 45),
        "the recording has 2 gaps, the longest from 0.019 to 0.03 s, where 0.001 s lie between other values:"
        " it is bridged",
    ),
    "end": ("time,a\n0,1\n0.005,2\n", "the recording ends at 0.005 s, the run at 0.02 s: its last value is held"),
    "milliseconds without a unit": (
        "time,a\n" + "".join(f"{n},{n}\n" for n in range(21)),
        "the recording lasts until 20 s, the run until 0.02 s",
    ),
    "begin": (
        "time,a\n0.01,1\n0.03,2\n",
        "the recording begins at 0.01 s: its first value is played from 0 s on",
    ),
}


def test_what_is_not_sampled_at_a_rate_has_no_gaps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rows are 1 and 1.8 ms apart in turn, and 7 ms once."""
    times = [milliseconds / 1000.0 for milliseconds in accumulate([0.0, *[1.0, 1.8] * 7, 7.0, 1.0, 1.0])]
    (tmp_path / "model.toml").write_text(RECORDED)
    (tmp_path / "log.csv").write_text("time,a\n" + "".join(f"{time},1\n" for time in times))
    ((checked, said),) = answers(tmp_path, capsys, "check")
    assert checked == 0
    assert "gap" not in said


@pytest.mark.defect("F7", before="bridged or held in silence", after="a note of check, with the times")
@pytest.mark.parametrize(("content", "note"), NOTES.values(), ids=NOTES)
def test_what_a_recording_leaves_open_is_told(
    content: str, note: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "model.toml").write_text(RECORDED)
    (tmp_path / "log.csv").write_text(content)
    (checked, said), (ran, _) = answers(tmp_path, capsys, "check", "run")
    assert (checked, ran) == (0, 0)
    assert f"model.toml:8: note: blocks.motion.file: {note}\n" in said
    assert said.count("note:") == 1


def test_steps_of_a_profile_are_no_gaps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "model.toml").write_text(RECORDED)
    (tmp_path / "log.csv").write_text("time,a\n0,1\n0.001,2\n0.005,3\n0.006,3\n0.1,4\n")
    ((checked, said),) = answers(tmp_path, capsys, "check")
    assert (checked, "note" in said) == (0, False)


REFUSED = {
    "averaging time": (
        changed(MEASURED, 'statistic = "mean"', 'statistic = "allan_deviation", tau = "2000 s"'),
        "measures.level.tau",
    ),
    "exact, of what is not linear": (changed(PENDULUM, '"auto"', '"exact"'), "cannot be stepped exactly"),
    "substeps": (changed(PENDULUM, "method", "substeps = 1000000000\nmethod"), "must be an integer within its bounds"),
    "length": (changed(MEASURED, '"20 ms"', '"1e15 s"'), "too long"),
    "constants": (changed(PENDULUM, "MassBetweenStops", 'MassSpringDamper", mass = "5e-324 kg'), "its derivatives"),
}


@pytest.mark.defect("F7", before="ready to run; the run then refuses", after="check refuses in the same words")
@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED)
def test_what_a_plan_refuses(text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "model.toml").write_text(text)
    (checked, why), (ran, refused) = answers(tmp_path, capsys, "check", "run")
    assert (checked, ran) == (1, 1)
    assert said in why
    assert why.splitlines()[:-1] == refused.splitlines()[:-1]


def test_what_the_command_line_may_say_is_a_note(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "model.toml").write_text(changed(MEASURED, 'duration = "20 ms"\n', ""))
    (checked, why), (ran, _) = answers(tmp_path, capsys, "check", "run")
    assert (checked, ran) == (0, 1)
    assert "note: duration: how long to run is not said" in why
    long = changed(changed(MEASURED, "[measures]", 'probes = ["source.output"]\n[measures]'), "20 ms", "1000000 s")
    (tmp_path / "model.toml").write_text(long)
    (checked, why), (ran, _) = answers(tmp_path, capsys, "check", "run")
    assert (checked, ran) == (0, 1)
    assert "note: probes: the traces are too large for memory" in why


STUDIED = MEASURED + '[study]\nruns = 2\nspread = { "source.value" = { normal = 1 } }\n'


@pytest.mark.defect("F7", before="ready to run; montecarlo then refuses", after="check refuses in the same words")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (changed(STUDIED, 'statistic = "mean"', 'statistic = "mean", from = "1 s"'), "ends before the measure begins"),
        (changed(STUDIED, 'duration = "20 ms"\n', ""), "how long to run is not said"),
        (changed(STUDIED, "normal = 1", 'file = "lot.csv", column = "a"'), "there is no file lot.csv"),
    ],
)
def test_what_a_study_refuses(text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "model.toml").write_text(text)
    (checked, why), (ran, refused) = answers(tmp_path, capsys, "check", "montecarlo")
    assert (checked, ran) == (1, 1)
    assert said in why
    assert why.splitlines()[:-1] == refused.splitlines()[:-1]


def test_a_study_of_its_own_file_is_planned_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    graph = RECORDED + '[measures]\nlevel = { signal = "gain.output", statistic = "mean" }\n'
    (tmp_path / "sensor.toml").write_text(graph)
    (tmp_path / "model.toml").write_text('graph = "sensor.toml"\nruns = 2\nspread = { "gain.gain" = { normal = 1 } }\n')
    (checked, why), (ran, _) = answers(tmp_path, capsys, "check", "montecarlo")
    assert (checked, ran) == (1, 1)
    assert "sensor.toml:8: blocks.motion.file: there is no such file" in why


def test_in_python_too() -> None:
    made: dict[str, Any] = {"name": "recorded", "rate": "1 kHz", "samples": 3}
    graph = Graph(**made, blocks={"motion": RecordedSignal(file="no.csv", unit="V")}, probes=["motion.output"])
    (problem,) = check(graph)
    assert problem.message == "there is no such file"
    with pytest.raises(ModelError) as caught:
        simulate(graph)
    assert caught.value.problems == (problem,)
    good = Graph(**made, blocks={"one": Constant()}, probes=["one.output"])
    assert check(good) == list[Problem]()


@pytest.mark.parametrize(
    ("ages", "said"), [("[0, 5, 10]", "10 s"), ("[0, 0.5]", "0.5 s"), ('["0 h", "10 h"]', "10 h"), ('[0, "1 d"]', "")]
)
def test_ages_below_a_day_are_noted(ages: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Ages without a unit are seconds: `[0, 5, 10]` was hardly meant for years of drift."""
    path = tmp_path / "study.toml"
    path.write_text(f'{MEASURED}[study]\nruns = 2\nspread."source.value" = {{ normal = 1 }}\nepochs.ages = {ages}\n')
    assert main(["check", str(path)]) == 0
    assert (f"note: epochs: the last age is {said}\n" in capsys.readouterr().out) == bool(said)
    assert main(["montecarlo", str(path)]) == 0
    assert (f"note: epochs: the last age is {said}\n" in capsys.readouterr().err) == bool(said)


@pytest.mark.defect("S959", before="0.8 about -2 V and 3 V is -0.8 of the values", after="a note says so")
@pytest.mark.parametrize("spread", ["{ normal = 0.1, relative = true }", "{ lognormal = 0.1 }", "{ normal = 0.1 }"])
@pytest.mark.parametrize("nominals", [(-2.0, 3.0), (2.0, -3.0), (-2.0, -3.0), (2.0, 3.0)])
def test_a_correlation_that_the_values_have_the_other_way_is_noted(
    nominals: tuple[float, float], spread: str, tmp_path: Path
) -> None:
    """What the values have is counted by NumPy, over 400 sensors."""
    first, second = nominals
    path = tmp_path / "study.toml"
    path.write_text(f"""
name = "two"
rate = "1 kHz"
samples = 2
blocks.a = {{ kind = "Constant", value = {first} }}
blocks.b = {{ kind = "Constant", value = {second} }}
measures.m = {{ signal = "a.output", statistic = "mean" }}
[study]
runs = 400
spread."a.value" = {spread}
spread."b.value" = {spread}
correlation."a.value" = {{ "b.value" = 0.8 }}
""")
    study = read_study(path)
    drawn = np.array([list(study.drawn(run)[0].values()) for run in range(400)])
    turned = bool(np.corrcoef(drawn.T)[0, 1] < 0.0)
    notes = [note for note in study_notes(study) if "turns the sign" in note.message]
    assert [(note.line, note.got) for note in notes] == [
        (12, "0.8 of the deviates, so about -0.8 of the values")
    ] * turned
