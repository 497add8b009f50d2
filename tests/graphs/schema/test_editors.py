"""Language servers for TOML name one place, the right one, for each of 60 mistakes in a graph or a study.

Taplo 0.9.0 (npm install @taplo/cli) and Tombi 1.9.6 (pip install tombi) were tried.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_file
from proofmass.runner.commands.schema_command import SCHEMA_FILE, STUDY_SCHEMA_FILE, write_schema_file

MORE = """
[measures]
bias = { signal = "adc.code", statistic = "mean" }
p99 = { signal = "adc.code", statistic = "percentile", percent = 99 }

[loops.main]
open_at = "adc.number"
phase_margin = "30 deg"

[exports]
code = "adc.code"

[integration]
accuracy = 1e-9

[requirements.small]
quantity = "bias"
at_most = 5

[tune.free]
"sensor.damping" = { at_least = 1e-3, at_most = 1e-2 }

[tune.goals]
wide = { loop = "main", figure = "bandwidth", at_least = "400 Hz" }

[blocks.clip]
kind = "Saturation"
lowest = -1.0

[blocks.total]
kind = "FixedGain"
input_format = "(16, 12)"
"""
GRAPH = library_file("template.toml").read_text(encoding="utf-8") + MORE
STUDY = library_file("margin_tolerance_study.toml").read_text(encoding="utf-8") + (
    '\n[epochs]\nages = ["0 h", "1 year"]\n\n[drift]\n"adc.reference" = { ramp = "20 ppm/year", relative = true }\n'
)
MISTAKES = (  # in a graph: what is written instead of what
    ("bits = 16", "bist = 16"),
    ("bits = 16", "bits = 64"),
    ("bits = 16", "bits = 1"),
    ("bits = 16", "bits = 16.5"),
    ("bits = 16", 'bits = "many"'),
    ("bits = 16", "bits = true"),
    ("bits = 16", "bits = [16]"),
    ('kind = "Sine"', 'kind = "Sinus"'),
    ('kind = "Gain"\ngain = "50', 'kind = "Gian"\ngain = "50'),
    ('kind = "MassSpringDamper"', "kind = 5"),
    ('kind = "AnalogToDigital"', 'kind = "ADC"'),
    ('rate = "10 kHz"', 'raet = "10 kHz"'),
    ('rate = "10 kHz"', "rate = -1"),
    ('rate = "10 kHz"', "rate = 0"),
    ('rate = "10 kHz"', 'rate = "fast"'),
    ('duration = "50 ms"', 'duraton = "50 ms"'),
    ('duration = "50 ms"', "duration = -0.05"),
    ('duration = "50 ms"', "duration = [50]"),
    ('name = "my accelerometer"', "name = 5"),
    ('name = "my accelerometer"', 'nmae = "x"'),
    ('mass = "50.43 ug"', 'mass = "fifty ug"'),
    ('mass = "50.43 ug"', "mass = -1.0"),
    ('mass = "50.43 ug"', "mass = 0"),
    ('mass = "50.43 ug"', 'mas = "50.43 ug"'),
    ('damping = "3.4e-3 kg/s"', "damping = -1"),
    ('stiffness = "49.5627 N/m"', "stifness = 3"),
    ('stiffness = "49.5627 N/m"', "stiffness = {}"),
    ('amplitude = "1 g0"', "amplitude = true"),
    ('amplitude = "1 g0"', 'ampliutde = "1 g0"'),
    ('frequency = "90 Hz"', 'freq = "90 Hz"'),
    ('unit = "m/s^2"', "unit = 1"),
    ('input_unit = "m"\n', 'inputunit = "m"\n'),
    ('reference = "10 V"', 'refrence = "10 V"'),
    ('reference = "10 V"', "reference = 0.0"),
    ("inertia.output -> sensor.force", "inertia.output > sensor.force"),
    ("inertia.output -> sensor.force", "inertia -> sensor"),
    ("inertia.output -> sensor.force", "Inertia.output -> sensor.force"),
    ('"inertia.output -> sensor.force"', "5"),
    ('"sensor.displacement", "adc.code"]', '"sensor", "adc.code"]'),
    ('"sensor.displacement", "adc.code"]', '{ signal = "adc.code", every = 0 }]'),
    ('"sensor.displacement", "adc.code"]', '{ signal = "adc.code", evry = 2 }]'),
    ('statistic = "mean"', 'statistic = "maen"'),
    ('statistic = "mean"', 'statistic = "mean", tau = 1'),
    ('bias = { signal = "adc.code"', 'bias = { signal = "adc"'),
    ("percent = 99", "percent = 101"),
    ('open_at = "adc.number"', 'open_at = "adc"'),
    ('phase_margin = "30 deg"', 'phase_margn = "30 deg"'),
    ('code = "adc.code"\n', 'code = "adc"\n'),
    ("accuracy = 1e-9", "acuracy = 1e-9"),
    ("accuracy = 1e-9", "accuracy = 10"),
    ("at_most = 5", "at_msot = 5"),
    ("lowest = -1.0", "lowset = -1.0"),
    ('"(16, 12)"', '"16, 12"'),
    ('figure = "bandwidth"', 'figure = "bandwith"'),
)
STUDY_MISTAKES = (
    ("runs = 200", "rnus = 200"),
    ("runs = 200", "runs = 0"),
    ("seed = 4", "seed = -4"),
    ('"pickoff.gain" = { normal', '"pickoff.gain" = { nromal'),
    ('ages = ["0 h", "1 year"]', "ages = []"),
    ('ramp = "20 ppm/year"', 'rmap = "20 ppm/year"'),
)
CASES = [(GRAPH, SCHEMA_FILE, *pair) for pair in MISTAKES] + [(STUDY, STUDY_SCHEMA_FILE, *p) for p in STUDY_MISTAKES]
CASES += [(GRAPH, SCHEMA_FILE, "", ""), (STUDY, STUDY_SCHEMA_FILE, "", "")]  # without a mistake
TOOLS = {
    "taplo": r"^error: .*\n.*?(\d+)\.toml:(\d+):\d+",
    "tombi": r"^ *Error: .*\n +at (\d+)\.toml:(\d+):\d+",  # its warnings are of style
}


@pytest.fixture(scope="module", params=TOOLS)
def marks(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[int, set[int]]:
    """The lines that a tool marks in each case, all files of a schema in one call."""
    name = str(request.param)
    tool = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    if tool is None:
        pytest.skip(f"no {name}")
    lines: dict[int, set[int]] = {number: set() for number in range(len(CASES))}
    for schema in (SCHEMA_FILE, STUDY_SCHEMA_FILE):
        folder = tmp_path_factory.mktemp(name)
        write_schema_file(folder / schema)
        (folder / "tombi.toml").write_text("[schema]\nstrict = false\n", encoding="utf-8")
        files = {f"{n}.toml": case for n, case in enumerate(CASES) if case[1] == schema}
        for file, (text, _, old, new) in files.items():
            (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
        options = ["--schema", (folder / schema).as_uri()] if name == "taplo" else ["--offline"]
        done = subprocess.run([tool, "lint", *options, *files], cwd=folder, capture_output=True, text=True, check=False)
        plain = re.sub(r"\x1b\[[0-9;]*m", "", done.stdout + done.stderr)
        for number, line in re.findall(TOOLS[name], plain, re.MULTILINE):
            lines[int(number)].add(int(line))
    return lines


def line_of(text: str, old: str, new: str) -> int:
    """The line of a mistake: the first that differs."""
    pairs = zip(text.splitlines(), text.replace(old, new, 1).splitlines(), strict=True)
    return next(number for number, (right, wrong) in enumerate(pairs, 1) if right != wrong)


@pytest.mark.exhaustive("tombi")
@pytest.mark.parametrize("number", range(len(CASES)), ids=[new or "right" for *_, new in CASES])
@pytest.mark.friendly(12, "editors mark the one line that is wrong")
def test_a_mistake_is_marked_where_it_is_and_nowhere_else(number: int, marks: dict[int, set[int]]) -> None:
    text, _, old, new = CASES[number]
    assert old in text
    assert marks[number] == ({line_of(text, old, new)} if new else set())


def test_there_are_sixty() -> None:
    assert len({*MISTAKES, *STUDY_MISTAKES}) == 60
