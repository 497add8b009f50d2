"""The commands spectrum, allan, noise and noise-model: what they say, draw and refuse."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from proofmass import noise, read_graph
from proofmass.runner.command_line import main

LIBRARY = Path(__file__).parents[3] / "graphs" / "library"
GRAPH = str(next(LIBRARY.rglob("recorded_motion.toml")))


def said(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    assert main(list(words)) == code
    captured = capsys.readouterr()
    return captured.out + captured.err


UNPROBED = """name = "bare"
rate = "1 kHz"
wires = ["noise.output -> gain.input", "gain.output -> last.input"]
blocks.noise = { kind = "WhiteNoise", density = "2 V/sqrt(Hz)", unit = "V" }
blocks.gain = { kind = "Gain", gain = 3.0, input_unit = "V", output_unit = "V" }
blocks.last = { kind = "UnitDelay", unit = "V" }
blocks.unused = { kind = "Step", unit = "V" }
blocks.tone = { kind = "Sine", unit = "V", frequency = "100 Hz" }
"""


def test_noise_without_probes_is_that_of_outputs_that_nothing_reads(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "bare.toml"
    file.write_text(UNPROBED, encoding="utf-8")
    (budget,) = json.loads(said(capsys, "noise", str(file), "--json"))
    assert budget["output"] == "last.output"
    assert budget["rms"] == pytest.approx(6.0 * np.sqrt(500.0))


@pytest.mark.defect("S865", before="0 rms: no noise reaches the converter", after="a step over sqrt(12), in doubt")
def test_noise_of_a_converter_that_only_signals_move(capsys: pytest.CaptureFixture[str]) -> None:
    """The graph that `proofmass new` writes."""
    data = json.loads(said(capsys, "noise", "library:template", "--output", "adc.code", "--json"))
    assert data["rms"] == pytest.approx(1.0 / math.sqrt(12.0))
    [source] = data["sources"]
    assert source["doubtful"]
    assert said(capsys, "noise", "library:template").endswith("no noise reaches sensor.displacement\n")


def test_noise_of_a_probe_that_is_no_number_hides_no_other(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "both.toml"
    blocks = 'blocks.noise = { kind = "WhiteNoise", density = 1.0 }\nblocks.above = { kind = "Comparator" }\n'
    probes = 'wires = ["noise.output -> above.input"]\nprobes = ["above.on", "noise.output"]\n'
    file.write_text(f'name = "both"\nrate = "1 kHz"\n{probes}{blocks}', encoding="utf-8")
    told = said(capsys, "noise", str(file))
    assert "noise of noise.output, 0 Hz to 500 Hz" in told
    assert told.endswith("not outputs of one number: above.on\n")
    said(capsys, "noise", str(file), "--output", "above.on", code=1)


PART = """name = "part"
rate = "1 kHz"
blocks.gain = { kind = "Gain", gain = 3.0 }
exports = { input = "gain.input", output = "gain.output" }
"""
WHOLE = """name = "whole"
rate = "1 kHz"
wires = ["white.output -> part.input"]
probes = ["white.output", "part.output"]
blocks.white = { kind = "WhiteNoise", density = "2 1/sqrt(Hz)" }
blocks.part = { graph = "part.toml" }
"""


@pytest.mark.defect("S854", before="a probe that a part exports: no noise reaches it", after="its budget")
def test_noise_of_a_probe_that_a_part_exports(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for name, text in (("part", PART), ("whole", WHOLE)):
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    budgets = json.loads(said(capsys, "noise", str(tmp_path / "whole.toml"), "--json"))
    assert [budget["rms"] for budget in budgets] == pytest.approx([2.0 * np.sqrt(500.0), 6.0 * np.sqrt(500.0)])


def test_noise_of_a_graph_without_wires_asks_for_an_output(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "alone.toml"
    file.write_text('name = "alone"\nrate = "1 kHz"\nblocks.step = { kind = "Step" }\n', encoding="utf-8")
    assert "name an output" in said(capsys, "noise", str(file), code=1)


@pytest.fixture
def recording(tmp_path: Path) -> str:
    """A rate of 0.05 deg/sqrt(h) at 50 Hz, and a tone."""
    count = 20_000
    white = np.random.default_rng(3).normal(size=count) * 0.05 / 60.0 * np.sqrt(50.0)
    tone = 0.3 * np.sin(2.0 * np.pi * 2.5 * np.arange(count) / 50.0)
    rows = [f"{i / 50.0!r},{w!r},{w + t!r}" for i, (w, t) in enumerate(zip(white.tolist(), tone.tolist(), strict=True))]
    path = tmp_path / "gyroscope.csv"
    path.write_text("\n".join(["time [s],rate [deg/s],turning [deg/s]", *rows]), encoding="utf-8")
    return str(path)


@pytest.mark.exhaustive
@pytest.mark.friendly(31, "of a recording")
def test_allan_of_a_recording(capsys: pytest.CaptureFixture[str], recording: str, tmp_path: Path) -> None:
    picture = tmp_path / "allan.svg"
    text = said(capsys, "allan", recording, "--probe", "rate", "--plot", str(picture))
    assert "rate: 20,000 values at 50 Hz, 400 s" in text
    assert "angle random walk          0.0" in text
    assert "not seen: below" in text
    assert picture.stat().st_size > 10_000
    data = json.loads(said(capsys, "allan", recording, "--json"))
    found = data["coefficients"]["N"]
    assert found["field_low"] <= 0.05 <= found["field_high"]
    assert found["field_unit"] == "deg/sqrt(h)"
    assert data["deviations"]["allan"]["deviation"][0] * np.sqrt(0.02) * 60.0 == pytest.approx(0.05, rel=0.02)


@pytest.mark.exhaustive
def test_spectrum_of_a_recording(capsys: pytest.CaptureFixture[str], recording: str, tmp_path: Path) -> None:
    picture = tmp_path / "spectrum.svg"
    words = ("spectrum", recording, "--probe", "turning", "--band", "0.1 Hz", "20 Hz", "--plot", str(picture))
    text = said(capsys, *words)
    assert "tone at 2.5" in text
    assert "slope" in text
    assert picture.stat().st_size > 10_000
    data = json.loads(said(capsys, *words[:4], "--json"))
    assert data["tone"]["coherent"]
    assert data["tone"]["rms"] == pytest.approx(0.3 / np.sqrt(2.0), rel=1e-3)
    assert "no tone stands out" in said(capsys, "spectrum", recording, "--probe", "rate")


@pytest.mark.exhaustive
def test_spectrum_and_allan_of_a_graph(capsys: pytest.CaptureFixture[str]) -> None:
    words = (GRAPH, "--probe", "adc.number", "--duration", "1 s", "--skip", "0.5 s", "--seed", "4")
    assert "adc.number: 2,501 values at 5000 Hz" in said(capsys, "spectrum", *words)
    assert "adc.number: 2,501 values at 5000 Hz" in said(capsys, "allan", *words)


def test_noise_of_a_graph(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "noise.svg"
    words = ("noise", GRAPH, "--output", "mean.mean", "--input", "motion.output")
    text = said(capsys, *words, "--plot", str(picture))
    assert "noise of mean.mean, 0 Hz to 50 Hz: 0.00204775 m/s^2 rms" in text
    assert "amplifier                    WhiteNoise" in text
    assert "velocity random walk" in text
    assert picture.stat().st_size > 10_000
    data = json.loads(said(capsys, *words, "--json"))
    assert sum(source["share"] for source in data["sources"]) == pytest.approx(1.0, rel=1e-12)
    assert data["referred_unit"] == "m/s^2"
    louder = json.loads(said(capsys, *words, "--json", "--set", "amplifier.density=0 V/sqrt(Hz)"))
    assert louder["rms"] < data["rms"]
    narrow = json.loads(said(capsys, *words, "--json", "--band", "1 Hz", "2 Hz"))
    assert narrow["rms"] == pytest.approx(data["density"][0] ** 0.5, rel=1e-3)  # white there, 1 Hz wide


def test_a_data_sheet_comes_back_from_its_blocks(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    figures = ("--arw", "0.1 deg/sqrt(h)", "--bias-instability", "1 deg/h", "--rrw", "2 deg/(h*sqrt(h))")
    path = tmp_path / "noise.toml"
    path.write_text(said(capsys, "noise-model", *figures, "--rate", "10 Hz"), encoding="utf-8")
    data = noise(read_graph(path), "noise.output", band=(1e-4, 5.0)).as_data()["coefficients"]
    assert data["N"]["field_value"] == pytest.approx(0.1, rel=0.01)
    assert data["B"]["field_value"] == pytest.approx(1.0, rel=0.03)  # of a ladder of filters
    assert data["K"]["field_value"] == pytest.approx(2.0, rel=0.03)


def test_the_flat_part_of_an_allan_curve_is_less_than_b(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("noise-model", "--density", "1 V/sqrt(Hz)", "--unit", "V", "--bias-instability", "1 V")
    levels = [
        float(line.split()[-1])
        for w in (words, (*words, "--flat"))
        for line in said(capsys, *w).splitlines()
        if "level" in line
    ]
    assert levels[1] / levels[0] == pytest.approx(1.0 / 0.664281, rel=1e-5)


@pytest.mark.defect("H940", before="not an angular rate, nor an acceleration", after="half of what 1 deg/h is")
def test_a_figure_of_a_data_sheet_may_be_a_fraction(capsys: pytest.CaptureFixture[str]) -> None:
    whole, half = (said(capsys, "noise-model", "--rrw", f"{n} deg/(h*sqrt(h))") for n in ("1", "1/2"))
    levels = [float(text.partition('coefficient = "')[2].split()[0]) for text in (whole, half)]
    assert levels[1] == pytest.approx(0.5 * levels[0], rel=1e-12)
    assert "unknown unit 'degg'" in said(capsys, "noise-model", "--arw", "1 degg/sqrt(h)", code=1)


@pytest.mark.defect("C910", before="ZeroDivisionError", after="must be > 0")
def test_flicker_noise_holds_for_some_time(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("noise-model", "--bias-instability", "1 deg/h", "--longest", "0 s")
    assert "longest: must be > 0" in said(capsys, *words, code=1)


VECTOR = """name = "two tones"
rate = "1 kHz"
samples = 500
wires = ["low.output -> join.first", "high.output -> join.second"]
probes = ["join.output"]
blocks.low = { kind = "Sine", amplitude = 1.0, frequency = "50 Hz", unit = "V" }
blocks.high = { kind = "Sine", amplitude = 3.0, frequency = "120 Hz", unit = "V" }
blocks.join = { kind = "VectorJoin", size = 2, unit = "V" }
"""


@pytest.mark.defect("H880", before="refused, with a hint to probe another output", after="the spectrum of an entry")
@pytest.mark.parametrize(("entry", "amplitude", "frequency"), [(0, 1.0, 50.0), (1, 3.0, 120.0)])
def test_an_entry_of_a_vector_has_a_spectrum(
    entry: int, amplitude: float, frequency: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "vector.toml").write_text(VECTOR)
    tone = json.loads(
        said(capsys, "spectrum", str(tmp_path / "vector.toml"), "--probe", f"join.output[{entry}]", "--json")
    )["tone"]
    assert tone["rms"] == pytest.approx(amplitude / math.sqrt(2.0), rel=1e-9)
    assert tone["frequency"] == pytest.approx(frequency, rel=1e-9)


@pytest.mark.parametrize(
    ("probe", "told"),
    [("join.output", "name one of its 2 entries, join.output[0]"), ("join.output[2]", "an entry below 2")],
)
def test_a_vector_says_which_entries_it_has(
    probe: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "vector.toml").write_text(VECTOR)
    assert told in said(capsys, "allan", str(tmp_path / "vector.toml"), "--probe", probe, code=1)


@pytest.mark.parametrize("command", ["spectrum", "allan"])
def test_all_probes_are_taken_where_none_is_named(capsys: pytest.CaptureFixture[str], command: str) -> None:
    words = (command, "library:template")
    every = json.loads(said(capsys, *words, "--json"))
    assert every == [
        json.loads(said(capsys, *words, "--json", "--probe", probe)) for probe in ("sensor.displacement", "adc.code")
    ]


def test_a_probe_without_an_answer_does_not_hide_the_others(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file, picture = tmp_path / "bare.toml", tmp_path / "noise.svg"
    file.write_text(UNPROBED.replace("rate =", 'probes = ["tone.output", "unused.output"]\nrate ='), encoding="utf-8")
    words = ("spectrum", str(file), "--samples", "1000", "--tone", "100 Hz")
    told = said(capsys, *words, "--plot", str(picture), code=1)
    assert "tone at 100" in told
    assert "unused.output: no tone stands out of the noise near 100 Hz" in told
    assert picture.exists()


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (("spectrum", "missing.csv"), 1, "there is no such file"),
        (("spectrum", GRAPH, "--probe", "adc.number", "--band", "2 Hz", "1 Hz"), 2, "must be above the first"),
        (("spectrum", GRAPH, "--probe", "adc.number", "--skip", "1 V"), 2, "--skip 1 V"),
        (("allan", "recording.csv", "--seed", "3"), 2, "--seed is for a graph"),
        (("noise", GRAPH, "--output", "adc.nothing"), 1, "adc.nothing"),
        (("noise-model",), 2, "say what the data sheet says"),
        (("noise-model", "--arw", "1 deg"), 1, "not all of an angular rate"),
        (("noise-model", "--arw", "1 deg/sqrt(h)", "--density", "1 deg/s/sqrt(Hz)"), 1, "not both"),
    ],
)
def test_what_is_wrong_is_told(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], code: int, text: str
) -> None:
    assert text in said(capsys, *words, code=code)


@pytest.mark.exhaustive
def test_the_report_of_a_run_has_the_budget(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The sources with their shares, the same in `noise.json` as by `proofmass noise --json`."""
    out = tmp_path / "run"
    words = ("run", GRAPH, "--samples", "200", "--out", str(out), "--noise", "mean.mean", "--noise", "adc.number")
    assert "noise.json" in said(capsys, *words)
    page = (out / "report.html").read_text(encoding="utf-8")
    for output in ("mean.mean", "adc.number"):
        assert f"Noise of {output}" in page
    data = json.loads(said(capsys, "noise", GRAPH, "--output", "mean.mean", "--json"))
    first, second = json.loads((out / "noise.json").read_text(encoding="utf-8"))
    assert first == data
    assert second["output"] == "adc.number"
    source = data["sources"][0]
    assert f">{100.0 * source['share']:.2f} %<" in page
    assert page.count("<svg") >= 4
    assert "--noise needs --out" in said(capsys, "run", GRAPH, "--noise", "mean.mean", code=2)


@pytest.mark.exhaustive
def test_noisy_graphs_settle(capsys: pytest.CaptureFixture[str]) -> None:
    """The operating point is found without noise."""
    data = json.loads(said(capsys, "noise", GRAPH, "--output", "mean.mean", "--at", "settled", "--json"))
    assert data["rms"] == pytest.approx(noise(read_graph(GRAPH), "mean.mean").rms, rel=1e-6)


def test_the_spread_of_one_value(capsys: pytest.CaptureFixture[str]) -> None:
    words = ("noise", GRAPH, "--output", "mean.mean", "--until", "40 ms")
    text = said(capsys, *words)
    assert text.startswith("mean.mean at 0.0")
    assert "from run to run +-0.002" in text
    rows = [line.split() for line in text.splitlines()[2:]]
    assert [row[0] for row in rows] == ["amplifier", "gas", "adc"]
    assert sum(float(row[2]) for row in rows) == pytest.approx(100.0, abs=0.02)
    data = json.loads(said(capsys, *words, "--json"))
    assert data["deviation"] ** 2 == pytest.approx(sum(v**2 for v in data["sources"].values()))
    told = said(capsys, *words, "--band", "1 Hz", "2 Hz", code=2)
    assert "--band: with --until there is one value" in told
