"""Mistakes that people make, each with the words of its answer that say what to do instead."""

import inspect
import re
from pathlib import Path

import pytest

import proofmass
from proofmass.blocks import Step
from proofmass.graphs.files.library import library_file
from proofmass.graphs.studies.ages import age_text
from proofmass.graphs.studies.study_reader import read_study_text
from tests.runner.commands.test_user_errors import Command, command

__all__ = ["command"]  # the fixture

TEMPLATE = library_file("template.toml").read_text(encoding="utf-8")
SENSOR = 'kind = "MassSpringDamper"'
AMPLITUDE = '"1 g0"'
DAMPING = '"3.4e-3 kg/s"'

# what is written instead of what, and words of the answer
MISTAKES = {
    "degrees Celsius": (DAMPING, '"25 °C"', 'temperatures are in K: 25 degC is "298.15 K"'),
    "root hertz": (DAMPING, '"10 ug0/rtHz"', "write sqrt(Hz)"),
    "degrees a second": (DAMPING, '"1 dps"', "write deg/s"),
    "power without a caret": (DAMPING, '"9.81 m/s2"', "write a power as s^2"),
    "decimal comma": (DAMPING, '"9,81 kg/s"', 'write a point: "9.81 kg/s"'),
    "milligrams": (AMPLITUDE, '"100 mg"', 'standard gravity is g0: "100 mg0"'),
    "seconds written out": ('"50 ms"', '"50 sec"', 'write "50 s"'),
    "capital letters": ("readout.output ->", "ReadOut.output ->", 'names are lower case: write "read_out.output ->'),
    "a block at the top": ("[blocks.sensor]", "[sensor]", "a block stands under blocks: write [blocks.sensor]"),
    "Scope": (SENSOR, 'kind = "Scope"', 'signals are recorded by probes: probes = ["block.output"]'),
    "Subsystem": (SENSOR, 'kind = "Subsystem"', 'a subgraph is a block with graph = "FILE.toml"'),
    "Limiter": (SENSOR, 'kind = "Limiter"', "here that is Saturation."),
    "Mux": (SENSOR, 'kind = "Mux"', "here that is VectorJoin."),
    "an own kind": (SENSOR, 'kind = "PeakDetector"', "Blocks of your own need --blocks FILE."),
    "two rates": ('bits = 16', 'rate = "9999.999 Hz"', "10 kHz for adc, for example"),
    "comment of C": ("bits = 16", "bits = 16 // resolution", "a comment begins with #"),
    "backslash": (SENSOR, 'graph = "parts\\axis.toml"', "in names of files write / instead"),
    "curly quotes": (SENSOR, "kind = \u201cMassSpringDamper\u201d", "the quotes are curly"),
    "percentile": ("[blocks.adc]", '[measures.p]\nsignal = "adc.code"\nstatistic = "percentile"\n[blocks.adc]',
                   "add percent = 99"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.friendly(7, "mistakes in files are answered by what to write")
def test_an_answer_says_what_to_write_instead(mistake: str, command: Command) -> None:
    old, new, words = MISTAKES[mistake]
    assert old in TEMPLATE
    Path("m.toml").write_text(TEMPLATE.replace(old, new), encoding="utf-8")
    answer = command("check", "m.toml")
    assert answer.code == 1
    assert words in answer.err
    assert answer.err.startswith("m.toml:")


@pytest.mark.friendly(6, "nine faults of one file at once")
def test_all_mistakes_are_told_at_once(command: Command) -> None:
    text = TEMPLATE
    for old, new in (
        ('rate = "10 kHz"', 'rate = "10 kHzz"'),
        ('"50 ms"', '"50 msec"'),
        ('kind = "Sine"', 'kind = "Sinus"'),
        ('"50.43 ug"', '"50.43 uV"'),
        ("damping =", "dampign ="),
        ("bits = 16", "bitz = 16"),
        ("sensor.displacement -> readout", "sensor.displacment -> readout"),
        ("inertia.output -> sensor.force", "inertia.outptu -> sensor.force"),
        ('"adc.code"]', '"adc.cod"]'),
    ):
        assert old in text
        text = text.replace(old, new)
    Path("m.toml").write_text(text, encoding="utf-8")
    answer = command("check", "m.toml")
    assert answer.err.endswith("9 problems in m.toml\n")


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (
            ["--probe", "sensor.velocty"],
            1,
            "--probe sensor.velocty: sensor.velocty is not an output",
        ),
        (["--seed", "abc"], 2, "'abc' is not a whole number, such as 1000000"),
        (["--samples", "1.5"], 2, "'1.5' is not a whole number"),
        (["--set", "adc.bits="], 1, "write its digits, such as 12"),
        (["--set", "adc.bits=9", "--set", "adc.bits=10"], 2, "--set adc.bits is given twice"),
        (["--set", "adc.rate=7"], 1, "the rates have no common base rate"),
        (["--set", "sensor.rate=1 kHz"], 1, "a continuous block has no rate"),
    ],
)
@pytest.mark.friendly(21, "a probe that is not there is told by its name")
def test_an_option_is_answered_by_its_own_name(options: list[str], code: int, words: str, command: Command) -> None:
    Path("m.toml").write_text(TEMPLATE.replace('"10 kHz"', '"1000.001 kHz"' if "=7" in options[1] else '"10 kHz"'))
    answer = command("run", "m.toml", *options)
    assert answer.code == code
    assert words in answer.err


@pytest.mark.friendly(14, "rates and the duration")
def test_rates_and_the_duration_are_set_from_the_shell(command: Command) -> None:
    Path("m.toml").write_text(TEMPLATE, encoding="utf-8")
    rates = command("run", "m.toml", "--set", "rate=20 kHz", "--set", "adc.rate=5 kHz", "--set", "duration=10 ms")
    assert "201 ticks at 20 kHz (10 ms)" in rates.out
    assert re.search(r"adc\.code +51 ", rates.out)
    samples = command("run", "m.toml", "--samples", "1e3")
    assert "1,000 ticks" in samples.out


def test_a_rate_that_is_a_formula_gives_way(command: Command) -> None:
    text = TEMPLATE.replace('rate = "10 kHz"', 'rate = "= 2 * pace"').replace(
        "[blocks.acceleration]", '[values]\npace = "5 kHz"\n[blocks.acceleration]', 1
    )
    Path("m.toml").write_text(text, encoding="utf-8")
    assert "at 10 kHz" in command("run", "m.toml").out
    assert "at 2 kHz" in command("run", "m.toml", "--set", "pace=1 kHz").out
    assert "at 4 kHz" in command("run", "m.toml", "--set", "rate=4 kHz").out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["margins", "library:closed_loop_accelerometer", "--plot", "x.jpg"], "x.jpg ends in none of .svg, .png, .pdf"),
        (["draw", "library:closed_loop_accelerometer", "-o", "x.png"], ".png is not a kind of diagram"),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_refused_before_any_work(
    words: list[str], message: str, command: Command
) -> None:
    answer = command(*words)
    assert (answer.code, answer.out) == (2, "")
    assert message in answer.err
    assert not list(Path().iterdir())


def test_a_folder_that_is_not_there_is_named(command: Command) -> None:
    answer = command("new", "x/y/z.toml")
    assert answer.code == 3
    assert answer.err == "cannot write x/y/z.toml\n  hint:     there is no folder x/y: make it\n"


def test_a_loop_is_answered_with_the_line_where_loops_are(command: Command) -> None:
    answer = command("margins", "library:closed_loop_accelerometer", "--loop", "mian")
    assert answer.code == 1
    assert "closed_loop_accelerometer.toml:25: loops: there is no such loop" in answer.err


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('[spread."adc.reference"]\nnormal = "200 ppm"', "a part of the value of the graph needs relative = true"),
        ('[drift."adc.reference"]\nramp = "20 ppm"', 'ramp = "20 ppm/year", relative = true'),
        ('[drift."adc.reference"]\nramp = "20 ppm"\nrelative = true', 'it is per time: ramp = "20 ppm/year"'),
        ('[spread.adc.reference]\nnormal = "1 mV"', 'quote the parameter\'s name, "adc.PARAMETER"'),
        ('[drift."adc.reference"]\nramp = "1 mV/year"', 'add [epochs] and below it ages = ["0 s", "10 years"]'),
    ],
)
@pytest.mark.friendly(7, "mistakes in studies are answered by what to write")
def test_a_study_is_answered(table: str, words: str) -> None:
    with pytest.raises(proofmass.ModelError) as wrong:
        read_study_text(f'graph = "library:closed_loop_accelerometer.toml"\nruns = 4\n{table}\n')
    assert words in str(wrong.value)


@pytest.mark.friendly(13, "ages are read as they are printed")
def test_ages_are_read_as_they_are_printed() -> None:
    ages = '[epochs]\nages = ["3 months", "1 year", "10 years"]\n'
    text = 'graph = "library:closed_loop_accelerometer.toml"\nruns = 4\nmargins = "0 s"\n'
    study = read_study_text(text + ages)
    assert [age_text(age) for age in study.epochs] == ["3 months", "1 year", "10 years"]


def test_the_number_of_runs_is_an_integer() -> None:
    with pytest.raises(proofmass.ModelError, match="runs: must be an integer"):
        read_study_text('graph = "library:closed_loop_accelerometer.toml"\nruns = "many"\n')


@pytest.mark.defect(
    "S88", before="a run of one tick, sources folded and codes at their ends, in silence", after="notes"
)
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('rate = "10 kHz"', 'rate = "10 mHz"', "the run is over after the tick at time 0"),
        ('"90 Hz"', '"90 kHz"', "the frequency is not below half the rate: the values are those of a lower one"),
        ('"10 V"', '"1 mV"', "the code stood at the end of its range\n  got:      499 of 501 rows at 32,767"),
        ('probes = ["sensor.displacement", "adc.code"]', "", "no probes: a run records nothing"),
    ],
)
def test_a_run_notes_what_nobody_meant(old: str, new: str, words: str, command: Command) -> None:
    assert "note" not in command("run", "library:template").err
    Path("m.toml").write_text(TEMPLATE.replace(old, new), encoding="utf-8")
    answer = command("run", "m.toml")
    assert answer.code == 0
    assert words in answer.err


def test_python_takes_names_of_files_and_answers_misspelt_names(tmp_path: Path) -> None:
    file = tmp_path / "sensor.toml"
    file.write_text(TEMPLATE, encoding="utf-8")
    result = proofmass.simulate(str(file))
    assert result.digest == proofmass.simulate(file).digest == proofmass.simulate("library:template").digest
    with pytest.raises(KeyError) as missing:
        result["adc.cod"]
    assert str(missing.value) == "'adc.cod' was not recorded; did you mean adc.code?"
    assert proofmass.margins("library:closed_loop_accelerometer").stable
    assert not [problem for problem in proofmass.check(file) if not problem.note]
    with pytest.raises(proofmass.ModelError, match=r"did you mean .*sensor\.toml"):
        proofmass.simulate(tmp_path / "senser.toml")
    with pytest.raises(proofmass.ModelError, match=r"name a port of acceleration: acceleration\.PORT"):
        proofmass.linearise(file, ["accel"], ["adc.number"])


@pytest.mark.friendly(8, "misspelt names of the package")
def test_the_package_answers_misspelt_names() -> None:
    with pytest.raises(AttributeError, match=r"did you mean simulate\?"):
        _ = proofmass.simulat
    with pytest.raises(AttributeError, match=r"from proofmass\.blocks import Step"):
        _ = proofmass.Step


def test_a_block_has_the_signature_of_its_parameters() -> None:
    signature = inspect.signature(Step)
    assert list(signature.parameters) == list(Step.parameters)
    assert str(signature.parameters["amplitude"]) == "amplitude: float = 1.0"
    assert signature.bind(amplitude=2.0).arguments == {"amplitude": 2.0}
    with pytest.raises(TypeError):
        signature.bind(ammplitude=2.0)


@pytest.mark.friendly(38, "messages have codes that explain tells")
def test_messages_have_codes_that_are_explained(command: Command) -> None:
    Path("m.toml").write_text(TEMPLATE.replace(DAMPING, '"1 dps"').replace('"Sine"', '"Sinus"'), encoding="utf-8")
    answer = command("check", "m.toml")
    assert "more: proofmass explain P0201 P0301\n2 problems in m.toml\n" in answer.err
    told = command("explain", "P0201", "p0301")
    assert told.code == 0
    assert told.out.startswith("P0201: There is no such kind of block\n  cause:")
    assert "P0301: A unit cannot be read" in told.out
    assert command("explain", "P9999").code == 2
    assert "P0404  An algebraic loop" in command("explain").out
    assert '"code": "P0301"' in command("check", "m.toml", "--json").out
