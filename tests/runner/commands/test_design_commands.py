"""`tune`, `fit` with recordings, `worst` and `margins` of several loops as the shell sees them."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from tests.by_hand.design_texts import COUPLED, INTEGRATING, RESONATOR, TUNE

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def loop(tmp_path: Path) -> Path:
    path = tmp_path / "loop.toml"
    path.write_text(INTEGRATING + TUNE, encoding="utf-8")
    return path


@pytest.fixture
def resonator(tmp_path: Path) -> Path:
    """A graph, and beside it a recording of a device with 5.4 N/m."""
    path = tmp_path / "resonator.toml"
    path.write_text(RESONATOR, encoding="utf-8")
    data = tmp_path / "run"
    force = "force.value=2uN"
    assert main(["run", str(path), "--set", "sensor.stiffness=5.4", "--set", force, "--out", str(data)]) == 0
    times = np.arange(2001) / 20e3
    w = np.sqrt(5.4 / 50e-9 - (5e-5 / 100e-9) ** 2)
    decay = np.exp(-times * 5e-5 / 100e-9)
    volts = 2.0 / 5.4 * (1.0 - decay * (np.cos(w * times) + 5e-5 / 100e-9 / w * np.sin(w * times)))
    volts += 1e-3 * np.random.default_rng(0).standard_normal(len(times))
    rows = [f"{t:.6f},2.0,{v:.9f}" for t, v in zip(times, volts, strict=True)]
    (tmp_path / "record.csv").write_text("\n".join(["time [s],push [uN],volts [V]", *rows]), encoding="utf-8")
    return path


@pytest.mark.exhaustive
def test_tune_writes_the_graph_with_its_comments(loop: Path, tmp_path: Path, capsys: Captured) -> None:
    picture, target = tmp_path / "tuned.png", tmp_path / "tuned.toml"
    given = ["--samples", "8", "--starts", "1", "--plot", str(picture), "--write", str(target)]
    assert main(["tune", str(loop), *given]) == 0
    out = capsys.readouterr().out
    assert "phase binds" in out
    assert picture.read_bytes().startswith(b"\x89PNG")
    before, after = loop.read_text(encoding="utf-8").splitlines(), target.read_text(encoding="utf-8").splitlines()
    assert [line for line in after if line not in before] == [
        f"gain = {read_graph(target).blocks['controller'].gain!r}             # slow at first"  # type: ignore[attr-defined]
    ]
    assert main(["check", str(target)]) == 0


@pytest.mark.exhaustive
def test_tune_starts_from_what_is_set(loop: Path, capsys: Captured) -> None:
    """Twice the gain of the plant leaves half of the controller's: their product alone is seen."""
    gains = []
    for changes in ([], ["--set", "plant.gain=2"]):
        assert main(["tune", str(loop), *changes, "--json", "--samples", "4", "--starts", "1"]) == 0
        gains.append(json.loads(capsys.readouterr().out)["parameters"]["controller.gain"]["after"])
    assert gains[0] == pytest.approx(2.0 * gains[1], rel=1e-4)
    assert main(["tune", str(loop), "--set", "plant.gain=2", "--write", str(loop)]) == 2
    assert "not together with --write" in capsys.readouterr().err


@pytest.mark.defect("C651", before="tune searched first and then said that it cannot write", after="it says so at once")
def test_tune_says_before_the_search_what_it_cannot_write(
    loop: Path, tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("proofmass.runner.commands.tune_command.tune", lambda *_, **__: pytest.fail("it searched"))
    for target in (tmp_path / "nowhere" / "tuned.toml", tmp_path):
        assert main(["tune", str(loop), "--write", str(target)]) != 0
        assert str(target) in capsys.readouterr().err
    text = loop.read_text(encoding="utf-8")
    begin, end = text.index("[blocks.controller]"), text.index("[blocks.computing]")
    loop.write_text(text[:begin] + '[blocks]\ncontroller = { kind = "Gain", gain = 100.0 }\n\n' + text[end:], "utf-8")
    assert main(["tune", str(loop), "--write", str(loop)]) != 0
    assert "controller" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_tune_as_json_and_what_cannot_be_met(loop: Path, capsys: Captured) -> None:
    loop.write_text(
        loop.read_text(encoding="utf-8").replace("maximise = true", 'at_least = "190 Hz"'), encoding="utf-8"
    )
    assert main(["tune", str(loop), "--json", "--samples", "4", "--starts", "1", "--write", str(loop)]) == 1
    captured = capsys.readouterr()
    answer = json.loads(captured.out)
    assert answer["met"] is False
    assert answer["goals"]["phase"]["binds"]
    assert "nothing was written" in captured.err


@pytest.mark.exhaustive
def test_fit_writes_what_it_finds(resonator: Path, tmp_path: Path, capsys: Captured) -> None:
    picture = tmp_path / "fit.svg"
    given = ["--data", str(tmp_path / "record.csv"), "--input", "force.output=push", "--output", "seen.output=volts"]
    free = ["--free", "sensor.stiffness=4 N/m..7 N/m", "--free", "sensor.damping"]
    assert main(["fit", str(resonator), *given, *free, "--plot", str(picture), "--write", str(resonator)]) == 0
    out = capsys.readouterr().out
    assert "2,001 rows, 0.1 s at 20000 Hz" in out
    assert read_graph(resonator).blocks["sensor"].stiffness == pytest.approx(5.4, rel=1e-3)  # type: ignore[attr-defined]
    assert "# as designed" in resonator.read_text(encoding="utf-8")
    assert "<svg" in picture.read_text(encoding="utf-8")


@pytest.mark.exhaustive
@pytest.mark.defect(
    "H898", before="what a fit had found was lost where its picture could not be written", after="shown"
)
def test_a_fit_is_shown_where_its_picture_cannot_be_written(resonator: Path, tmp_path: Path, capsys: Captured) -> None:
    given = ["--data", str(tmp_path / "record.csv"), "--input", "force.output=push", "--output", "seen.output=volts"]
    free = ["--free", "sensor.stiffness=4 N/m..7 N/m", "--free", "sensor.damping"]
    picture = resonator / "fit.svg"
    assert main(["fit", str(resonator), *given, *free, "--plot", str(picture)]) == 3
    captured = capsys.readouterr()
    assert "sensor.stiffness" in captured.out
    assert f"cannot write or read {picture}" in captured.err


@pytest.mark.exhaustive
def test_fit_refuses_to_write_what_is_not_determined(resonator: Path, tmp_path: Path, capsys: Captured) -> None:
    given = ["--data", str(tmp_path / "record.csv"), "--input", "force.output=push", "--output", "seen.output=volts"]
    before = resonator.read_text(encoding="utf-8")
    free = [word for name in ("stiffness", "damping", "mass") for word in ("--free", f"sensor.{name}")]
    assert (
        main(["fit", str(resonator), *given, *free, "--free", "readout.gain", "--json", "--write", str(resonator)]) == 1
    )
    captured = capsys.readouterr()
    assert json.loads(captured.out)["determined"] is False
    assert "nothing was written" in captured.err
    assert resonator.read_text(encoding="utf-8") == before


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--free", "sensor.mass"], "--free needs --data"),
        (["--data", "x.csv", "--free", "sensor.mass"], "name what was recorded"),
        (["--data", "x.csv", "--output", "seen.output", "--order", "3"], "--order: an option of temperature laws"),
        (["--temperature", "a.b", "--output", "seen.output", "--tries", "3"], "--tries: an option of recordings"),
        (["--data", "x.csv", "--output", "seen.output", "--free", "sensor.mass=3"], "write bounds as"),
        (["--data", "x.csv", "--output", "volts", "--free", "sensor.mass"], "write BLOCK.PORT=COLUMN"),
        (["--temperature", "a", "--output", "b", "--output", "c"], "has one output"),
    ],
)
def test_fit_says_which_options_go_together(resonator: Path, capsys: Captured, words: list[str], said: str) -> None:
    assert main(["fit", str(resonator), *words]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.exhaustive
def test_worst_of_a_graph_and_of_a_study(loop: Path, tmp_path: Path, capsys: Captured) -> None:
    picture = tmp_path / "worst.png"
    given = ["--tolerance", "controller.gain=10 %", "--figure", "main:phase_margin", "--samples", "5"]
    assert main(["worst", str(loop), *given, "--plot", str(picture)]) == 0
    out = capsys.readouterr().out
    assert "at a corner" in out
    assert "a search, not a proof" in out
    assert picture.exists()
    spread = '[study]\nmargins = "0 s"\n[study.spread]\n"plant.gain" = { uniform = 0.1 }\n'
    loop.write_text(INTEGRATING + spread, encoding="utf-8")
    assert main(["worst", str(loop), "--json", "--samples", "5"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert set(answer["cases"]) == {"main.gain_margin", "main.phase_margin"}
    assert answer["cases"]["main.gain_margin"]["worst"] == pytest.approx(-20.0 * np.log10(0.11), rel=1e-6)
    for words, said in ((["--figure", "phase"], "LOOP:FIGURE"), (["--tolerance", "gain"], "BLOCK.PARAMETER")):
        assert main(["worst", str(loop), *words]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.defect("S806", before="with --set the spread of a graph's own study did not count", after="it counts too")
def test_the_spread_of_a_study_counts_beside_tolerances_and_changes(loop: Path, capsys: Captured) -> None:
    """K T is 0.05 nominal, and 0.05 1.1 1.1 at the worst, of which 1 / (K T) is the gain margin."""
    spread = '[study]\n[study.spread]\n"plant.gain" = { uniform = 0.1 }\n'
    loop.write_text(INTEGRATING + spread, encoding="utf-8")
    words = ["--tolerance", "controller.gain=10 %", "--set", "controller.gain=50", "--samples", "5", "--json"]
    assert main(["worst", str(loop), *words]) == 0
    case = json.loads(capsys.readouterr().out)["cases"]["main.gain_margin"]
    assert case["worst"] == pytest.approx(20.0 * math.log10(1.0 / (0.05 * 1.1 * 1.1)))


@pytest.mark.exhaustive
def test_margins_of_several_loops_and_over_a_parameter(tmp_path: Path, capsys: Captured) -> None:
    path, picture = tmp_path / "coupled.toml", tmp_path / "together.png"
    path.write_text(COUPLED, encoding="utf-8")
    assert main(["margins", str(path), "--together", "--plot", str(picture)]) == 0
    assert "2 loops at once" in capsys.readouterr().out
    assert picture.exists()
    assert main(["margins", str(path), "--loop", "x", "--with", "y", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["disk_margin"] == pytest.approx(0.65241745, rel=1e-6)
    assert main(["margins", str(path), "--over", "x_gain.gain=100..2000:3"]) == 1
    assert "unstable" in capsys.readouterr().out
    for over, said in (("x_gain.gain", "write age, or"), ("x_gian.gain=1..2", "x_gain")):
        assert main(["margins", str(path), "--over", over]) in (1, 2)
        assert said in capsys.readouterr().err


@pytest.mark.exhaustive
def test_named_values_and_yields_on_the_command_line(tmp_path: Path, capsys: Captured) -> None:
    """The gain is ten times a named value; the settled plant is at 1, or at the value drawn."""
    text = INTEGRATING.replace("[loops.main]", '[values]\nspeed = "10 Hz"\n\n[loops.main]')
    text = text.replace("gain = 100.0 ", 'gain = "= 10 * speed / (1 Hz)" ').replace("1e-3 1/sqrt", "1e-9 1/sqrt")
    text += '\n[study]\nruns = 32\n[study.spread]\n"wanted.amplitude" = { uniform = 0.1 }\n'
    text += "[study.limits]\nend = { at_least = 0.8 }\n"
    path = tmp_path / "loop.toml"
    path.write_text(text, encoding="utf-8")
    words = ["worst", str(path), "--tolerance", "speed=10 %", "--figure", "main:phase_margin", "--samples", "3"]
    assert main([*words, "--runs", "16", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    phase = answer["cases"]["main:phase_margin"]
    assert phase["at"]["speed"] == pytest.approx(11.0)
    assert phase["worst"] == pytest.approx(90.0 - 3.0 * np.degrees(np.arcsin(0.055)), rel=1e-9)
    assert answer["yields"]["end"][0] == 1.0
    words = ["worst", str(path), "--tolerance", "wanted.amplitude=0.25", "--yield", "end", "--samples", "1", "--json"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["cases"]["yield of end"]["worst"] < 0.8
    given = ["--response", "plant.output:gain@10Hz", "--input", "wanted.output", "--tolerance", "speed=10 %"]
    assert main(["worst", str(path), *given, "--samples", "1", "--quiet"]) == 0
    assert "gain of plant.output" in capsys.readouterr().out
    assert main(["margins", str(path), "--over", "speed=10 Hz..20 Hz:2"]) == 0
    assert f"{90.0 - 3.0 * np.degrees(np.arcsin(0.1)):.4g} deg" in capsys.readouterr().out
    assert main(["margins", str(path), "--over", "sped=1 Hz..2 Hz"]) == 1
    assert "did you mean speed?" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_what_is_expected_holds_a_fit(resonator: Path, capsys: Captured) -> None:
    given = ["--data", str(resonator.parent / "record.csv"), "--input", "force.output=push", "--json"]
    given += ["--output", "seen.output=volts", "--free", "sensor.stiffness=5 N/m +- 1 nN/m"]
    assert main(["fit", str(resonator), *given]) in (0, 1)
    (estimate,) = json.loads(capsys.readouterr().out)["parameters"].values()
    assert estimate["value"] == pytest.approx(5.0, rel=1e-6), "a recording of 5.4 N/m does not outweigh it"
