"""The command response: what it says, draws and refuses."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.runner.commands.test_noise_commands import GRAPH, said

WORDS = ("response", GRAPH, "motion.output", "mean.mean")


def test_linear_response(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "response.svg"
    text = said(capsys, *WORDS, "--plot", str(picture))
    assert "mean.mean by motion.output, linear at 0.01 s" in text
    assert "bandwidth         44.3 Hz, -3 dB" in text
    assert "step              rises from 10 % to 90 % in 8.1677 ms" in text
    assert picture.stat().st_size > 10_000


def test_a_response_without_names_is_from_the_only_source_to_all_probes(capsys: pytest.CaptureFixture[str]) -> None:
    every = json.loads(said(capsys, "response", "library:template", "--json"))
    assert [one["output"] for one in every] == ["sensor.displacement", "adc.code"]
    assert {one["input"] for one in every} == {"acceleration.output"}


def test_several_sources_are_told_with_the_line_to_write(capsys: pytest.CaptureFixture[str]) -> None:
    told = said(capsys, "response", "library:closed_loop_accelerometer", code=1)
    assert "got:      acceleration.output, reference.output" in told
    assert "write proofmass response GRAPH acceleration.output dac.code" in told


def test_sources_of_a_probe_that_a_subgraph_exports_are_told_too(capsys: pytest.CaptureFixture[str]) -> None:
    told = said(capsys, "response", "library:six_axis_imu", code=1)
    assert "turn.output" in told
    assert "GRAPH gravity.output gyroscope_x.output" in told


HIGH_PASS = """name = "high pass"
rate = "10 kHz"
wires = ["step.output -> filter.input"]
blocks.step = { kind = "Step" }
blocks.filter = { kind = "TransferFunction", numerator = [1.0, 0.01], denominator = [1.0, 100.0] }
"""


def test_a_step_that_comes_back_has_a_peak_instead_of_an_overshoot(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "high.toml"
    file.write_text(HIGH_PASS, encoding="utf-8")
    assert "peak 1 after 0 s, back to 0.0001" in said(capsys, "response", str(file))


@pytest.mark.exhaustive
@pytest.mark.friendly(13, "a stimulus has its peak as it was written")
def test_simulated_response(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "response.png"
    words = (*WORDS, "--simulate", "multitone", "--amplitude", "1 g0", "--band", "1 Hz", "40 Hz")
    data = json.loads(said(capsys, *words, "--json"))["simulated"]
    assert data["amplitude"] == pytest.approx(9.80665)
    assert data["input_unit"] == "m/s^2"
    assert np.max(np.abs(data["deviation_db"])) < 0.01
    text = said(capsys, *words, "--plot", str(picture))
    assert "simulated, multitone of 1 g0, " in text
    assert "from linear at these frequencies; at others" in text
    assert picture.stat().st_size > 10_000


@pytest.mark.exhaustive("words5-1-does not move")
@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ((*WORDS, "--amplitude", "1 g0"), 2, "add --simulate multitone"),
        ((*WORDS, "--simulate", "sine"), 1, "the stimulus needs an amplitude"),
        ((*WORDS, "--simulate", "sine", "--amplitude", "1 V"), 1, "a quantity in m/s^2"),
        ((*WORDS, "--simulate", "sine", "--amplitude", "1 g0", "--band", "1 Hz", "2 kHz"), 1, "up to 50 Hz"),
        (("response", GRAPH, "motion.output", "mean.meen"), 1, "did you mean mean?"),
        (("response", GRAPH, "mean.mean", "motion.output"), 1, "does not move"),
        ((*WORDS, "--at", "soon"), 1, "at:"),
    ],
)
def test_what_is_wrong_is_told(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], code: int, text: str
) -> None:
    assert text in said(capsys, *words, code=code)
