"""`prove` and `check-proof` as the shell sees them."""

import json
from pathlib import Path

import pytest

from proofmass.runner.command_line import main
from proofmass.runner.design.proof.contraction import Norm
from tests.by_hand.design_texts import INTEGRATING

Captured = pytest.CaptureFixture[str]
Patch = pytest.MonkeyPatch


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("loop.toml").write_text(INTEGRATING, encoding="utf-8")
    return "loop.toml"


def test_claims_are_proved_and_the_certificate_holds(loop: str, capsys: Captured) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--gain-margin", "10 dB", "--out", "proof.json"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "controller.gain from 90 to 110" in shown
    assert shown.count(" proved ") == 3
    assert "wrote proof.json" in shown
    assert main(["check-proof", "proof.json", loop]) == 0
    shown = capsys.readouterr().out
    assert "main, gain margin of at least 10 dB: 1 box" in shown
    assert "taken for granted" in shown
    assert main(["check-proof", "proof.json", "library:template"]) == 1
    assert "is that of another graph" in capsys.readouterr().out
    text = Path("proof.json").read_text(encoding="utf-8")
    Path("proof.json").write_text(text.replace('"limit": 10.0', '"limit": 11.0'), encoding="utf-8")
    assert main(["check-proof", "proof.json", "--json"]) == 1
    assert json.loads(capsys.readouterr().out) == {"valid": False, "why": "was changed: its hash is another"}


OF_ITS_STUDY = """
[study]
runs = 10
[study.spread]
"controller.gain" = { uniform = 0.1, relative = true }
[study.sweep]
"plant.gain" = [0.9, 1.0, 1.05]
[study.drift]
"wanted.amplitude" = { ramp = "1 ppm/year", relative = true }
[study.epochs]
ages = ["0 h", "1000 h"]
"""


def test_the_study_of_a_graph_says_what_varies(loop: str, capsys: Captured) -> None:
    """At the worst K T is 0.1155: margins of 1 / K T and 90 deg - 3 asin(K T / 2), 18.748 dB and 80.068 deg."""
    Path(loop).write_text(INTEGRATING + OF_ITS_STUDY, encoding="utf-8")
    assert main(["prove", loop, "--gain-margin", "18.7 dB", "--phase-margin", "79.9 deg"]) == 0
    shown = capsys.readouterr().out
    assert "controller.gain from 90 to 110, plant.gain from 0.9 1/s to 1.05 1/s" in shown
    assert "wanted.amplitude from 1 to 1, at all ages" in shown
    assert main(["prove", loop, "--gain-margin", "18.7 dB", "--set", "controller.gain=110"]) == 1
    assert "controller.gain from 99 to 121" in capsys.readouterr().out
    Path(loop).write_text(f"{INTEGRATING}[study]\nruns = 10\n", encoding="utf-8")
    assert main(["prove", loop]) == 0
    assert "nothing varies" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_a_refuted_claim_has_a_line_to_type(loop: str, capsys: Captured) -> None:
    """90 deg - 3 asin(K T / 2) is 81.4 deg for the sensor as it is, and 80.5 deg at its largest gain."""
    assert main(["prove", loop, "--tolerance", "controller.gain=10 %", "--phase-margin", "81 deg"]) == 1
    shown = capsys.readouterr().out
    assert "phase margin of at least 81 deg  refuted" in shown
    (line,) = [line for line in shown.splitlines() if line.strip().startswith("proofmass margins")]
    setting = line.split('--set "')[1].rstrip('"')
    assert main(["margins", loop, "--at", "0 s", "--loop", "main", "--set", setting, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert "phase_margin_deg" in json.dumps(found)
    gain = float(setting.split("=")[1])
    assert gain > 100.0


@pytest.mark.exhaustive
def test_bounds_have_the_least_that_was_found_beside_them(loop: str, capsys: Captured) -> None:
    assert main(["prove", loop, "--tolerance", "controller.gain=10 %", "--bounds"]) == 0
    shown = capsys.readouterr().out
    (row,) = [
        line for line in shown.splitlines() if line.startswith("  gain margin") or line.startswith("gain margin of at")
    ]
    proved, found = (float(word) for word in (row.split(" dB")[0].split()[-1], row.split("; ")[1].split()[0]))
    assert 6.0 < 0.9 * found < proved < found
    (line,) = [line for line in shown.splitlines() if line.strip().startswith("proofmass margins")][:1]
    setting = line.split('--set "')[1].rstrip('"')
    assert main(["margins", loop, "--at", "0 s", "--loop", "main", "--set", setting]) == 0
    assert f"{found:.2f} dB" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_other_claims_and_a_second_call_that_goes_on(loop: str, capsys: Captured, monkeypatch: Patch) -> None:
    others = ["--disk-margin", "1", "--delay-margin", "5 ms", "--decay-rate", "50 1/s"]
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", *others, "--out", "proof.json", "--quiet"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "delay margin of at least 5 ms" in shown
    assert "decay rate of at least 50 1/s" in shown
    assert shown.count(" proved ") == 6
    monkeypatch.setattr(Norm, "improved", lambda norm: pytest.fail("what is proved is searched again"))
    assert main(words) == 0
    assert main(["check-proof", "proof.json", loop]) == 0
    assert "main, disk margin of at least 1: 1 box" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_limits_and_bounds_of_a_scale_factor(loop: str, capsys: Captured) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--input", "wanted.output"]
    assert main([*words, "--scale-factor", "plant.output=0.99..1.01", "--out", "proof.json", "--quiet"]) == 0
    shown = capsys.readouterr().out
    assert "from wanted.output to plant.output" in shown
    assert "stable" not in shown
    assert main(["check-proof", "proof.json", loop]) == 0
    assert "wanted.output to plant.output, scale factor of at most 1.01: 1 box" in capsys.readouterr().out
    assert main([*words, "--scale-factor", "plant.output", "--json"]) == 0
    for one in json.loads(capsys.readouterr().out)["proofs"]:
        assert (one["status"], one["least_found"]["margin"]) == ("proved", pytest.approx(1.0))
    assert main([*words, "--scale-factor", "plant.output=1.01.."]) == 1
    assert "refuted  scale factor 1 at the sensor below" in capsys.readouterr().out
    assert main([*words, "--scale-factor", "plannt.output=0.99..1.01"]) == 1
    assert "did you mean plant" in capsys.readouterr().err


@pytest.mark.exhaustive
def test_a_limit_of_noise(loop: str, capsys: Captured) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--noise"]
    assert main([*words, "plant.output=0.006", "--out", "proof.json", "--quiet"]) == 0
    assert "noise of at most 0.006  proved" in capsys.readouterr().out
    assert main(["check-proof", "proof.json", loop]) == 0
    shown = capsys.readouterr().out
    assert "plant.output, noise of at most 0.006: " in shown
    assert "sources of noise" in shown.lower()
    assert main([*words, "plant.output=0.005"]) == 1
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.strip().startswith("proofmass noise")]
    setting = line.split('--set "')[1].rstrip('"')
    assert main(["noise", loop, "--output", "plant.output", "--set", setting, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rms"] > 0.005


def test_a_limit_of_a_peak(loop: str, capsys: Captured) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--input", "wanted.output", "--peak"]
    assert main([*words, "plant.output=1.01", "--out", "proof.json", "--quiet"]) == 0
    shown = capsys.readouterr().out
    assert "from wanted.output to plant.output" in shown
    assert "peak of at most 1.01  proved" in shown
    assert main(["check-proof", "proof.json", loop]) == 0
    assert "wanted.output to plant.output, peak of at most 1.01: " in capsys.readouterr().out
    assert main([*words, "plant.output=0.99"]) == 1
    assert "refuted" in capsys.readouterr().out
    assert main(["prove", loop, "--peak", "plant.output=1"]) == 1
    assert "a peak needs an input" in capsys.readouterr().err


def test_parameters_may_change_from_period_to_period(loop: str, capsys: Captured) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--any-change", "--out", "proof.json", "--quiet"]
    assert main([*words, "--json"]) == 0
    claims = [one["claim"] for one in json.loads(capsys.readouterr().out)["proofs"]]
    assert claims[:2] == ["stable under any change", "gain margin of at least 6 dB under any change"]
    assert main(["check-proof", "proof.json", loop]) == 0
    assert "main, stable under any change: 1 box" in capsys.readouterr().out


def test_a_bias_at_a_constant_input(loop: str, capsys: Captured) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--constant", "wanted.output=0.5..1", "--quiet"]
    assert main([*words, "--bias", "plant.output=0.499..1.001", "--out", "proof.json"]) == 0
    shown = capsys.readouterr().out
    assert "for every sensor, at rest, with controller.gain from 90 to 110, wanted.value from 0.5 to 1" in shown
    assert "bias of at most 1.001" in shown
    assert main(["check-proof", "proof.json", loop]) == 0
    assert "plant.output, bias of at most 1.001 at rest: " in capsys.readouterr().out
    assert main([*words, "--bias", "plant.output=0.499..0.9"]) == 1
    shown = capsys.readouterr().out
    assert "not bias of at most 0.9, of plant.output, where wanted.value = 1: see it by" in shown
    assert "run GRAPH --probe plant.output --set" in shown
    assert main(["prove", loop, "--at", "settled", "--json"]) == 0
    assert all(one["at_rest"] for one in json.loads(capsys.readouterr().out)["proofs"])
    assert main(["prove", loop, "--constant", "wanted.output=1 V"]) == 1
    assert "V is" in capsys.readouterr().err


@pytest.mark.defect("C877", before="a bias of zero was proved, and its certificate refused", after="it holds")
@pytest.mark.parametrize("limits", ["", "=-1e-12..1e-12", "=-1e-30..1e-30"])
def test_a_bias_of_zero(loop: str, capsys: Captured, limits: str) -> None:
    words = ["prove", loop, "--tolerance", "controller.gain=10 %", "--input", "wanted.output", "--quiet"]
    assert main([*words, "--bias", f"plant.output{limits}", "--out", "proof.json"]) == 0
    assert capsys.readouterr().out.count(" proved ") == 2
    assert main(["check-proof", "proof.json", loop]) == 0
    assert capsys.readouterr().out.count("wanted.output to plant.output, bias of at") == 2


def test_json_has_each_claim(loop: str, capsys: Captured) -> None:
    assert main(["prove", loop, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["proved"] is True
    assert [one["status"] for one in data["proofs"]] == ["proved"] * 3


def test_wrong_options_are_answered(loop: str, capsys: Captured) -> None:
    assert main(["prove", loop, "--tolerance", "controller.gain"]) == 2
    assert main(["prove", loop, "--tolerance", "controller.gian=5 %"]) == 1
    assert "did you mean" in capsys.readouterr().err
    assert main(["prove", loop, "--phase-margin", "4 V"]) == 1
    assert main(["check-proof", loop]) == 1
