"""A hint is never wrong: mistakes are made in files, what each hint says is done, and the problem is gone then."""

import re
from collections.abc import Iterator

import pytest

from proofmass.blocks import Constant, LowPass, Sum
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.check import checked
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.build import Graph
from tests.by_hand.graph_texts import check_text

TEMPLATE = (
    library_file("template.toml")
    .read_text(encoding="utf-8")
    .replace(
        "[blocks.acceleration]",
        '[measures]\nbias = { signal = "adc.code", statistic = "mean" }\n\n[blocks.acceleration]',
        1,
    )
)
LOOP = library_file("closed_loop_accelerometer.toml").read_text(encoding="utf-8")
STUDY = LOOP + (
    '\n[measures]\ndrift = { signal = "dac.code", statistic = "mean", from = "1 s" }\n\n[study]\nruns = 20\n'
    '\n[study.spread]\n"torquer.gain" = { normal = "500 ppm", relative = true, truncated = 3 }\n'
    '\n[study.epochs]\nages = ["0 h", "1 year", "10 year"]\n'
    '\n[study.drift]\n"reference.slope" = { ramp = "1 uV/s/year" }\n\n[study.limits]\ndrift = { at_most = 5.0 }\n'
)
NAMES = {  # names that stand in a file, each misspelt in three ways: a letter left out, two swapped, one doubled
    TEMPLATE: (
        "duration", "probes", "measures", "statistic", "amplitude", "frequency", "stiffness", "damping", "reference",
        "input_unit", "output_unit", "MassSpringDamper", "AnalogToDigital", "displacement ->", "voltage\"", "force\"",
        "inertia.output", "sensor.force", "readout.input", "acceleration.output",
    ),
    LOOP: (
        "samples", "requirements", "open_at", "FlexurePendulum", "DigitalToAnalog", "proportional", "integral",
        "derivative_gain", "derivative_pole", "pendulum.torque", "torquer.input", "resistor.output", "dac.reference",
        "Negation", "offset", "slope", "minimise",
    ),
    STUDY: ("spread", "epochs", "normal", "relative", "truncated", "limits", "at_most", "runs"),
}  # fmt: skip
UNITS = {  # what is written instead of a quantity
    "50.43 ug": ("50 ugr", "50 Ug", "50 microgram", "50 grams", "50 kilogram"),
    "90 Hz": ("90 hz", "90 HZ", "90 Herz", "90 hertz", "0.09 khz", "0.09 KHz"),
    "3.4e-3 kg/s": ("3.4 g/sec", "3.4e-3 Kg/s", "3.4e-3 kg/secs", "3.4e-3 kg/sek", "3.4e-3 N*sec/m"),
    "49.5627 N/m": ("3.16 Nr/m", "3.16 n/m", "3.16 N/M", "3.16 newton/m", "3.16 N/meter", "3.16 mN/mmm"),
    "10 V": ("10 volt", "10 Volts", "10 v", "1e4 mv", "10 Vo"),
    "1 g0": ("9.81 m/s2", "1 g", "1 gee", "100 mg", "10 m/sec^2"),
    "3.53e8 V/m": ("353 V/u", "353 V/micron", "3.53e8 v/m", "353 mV/nmm"),
    "50 ms": ("50 msec", "50 mS", "0.05 sec", "0.05 seconds", "50 msecs"),
}
WRITTEN = (  # other mistakes in the template
    ('"inertia.output -> sensor.force"', '"inertia -> sensor"'),
    ('"inertia.output -> sensor.force"', '"inertia.output -> sensor"'),
    ('"inertia.output -> sensor.force"', '"inertia -> sensor.force"'),
    ('"readout.output -> adc.voltage"', '"readout -> adc"'),
    ('"sensor.displacement -> readout.input"', '"sensor -> readout"'),
    ('"inertia.output -> sensor.force"', '"sensor.force -> inertia.output"'),
    ('"readout.output -> adc.voltage"', '"adc.voltage -> readout.output"'),
    ('"acceleration.output -> inertia.input"', '"inertia.input -> acceleration.output"'),
    ('"3.4e-3 kg/s"', '"3,4e-3 kg/s"'),
    ('"50.43 ug"', '"50,43 ug"'),
    ('"mean"', '"average"'),
    ('"mean"', '"sigma"'),
    ('"mean"', '"maximum"'),
    ('"mean"', '"p2p"'),
    ('"mean"', '"final"'),
)  # fmt: skip
LINES = (  # lines that are not TOML
    ("bits = 16", "bits = 16\nlimited = True"),
    ('frequency = "90 Hz"', "frequency = 90 Hz"),
    ('mass = "50.43 ug"', "mass = 50.43 ug"),
    ('kind = "Sine"', "kind = Sine"),
    ('rate = "10 kHz"', "rate = 10 kHz"),
)


def slips(name: str) -> Iterator[str]:
    """Three slips in the middle of the longest word of a name."""
    word = max(re.findall(r"[A-Za-z_]+", name), key=len)
    at = len(word) // 2
    swapped = word[: at - 1] + word[at] + word[at - 1] + word[at + 1 :]
    for wrong in (word[:at] + word[at + 1 :], swapped, word[:at] + word[at] + word[at:]):
        if wrong != word:
            yield name.replace(word, wrong, 1)


MISSPELT = [
    (text, text.replace(name, slip, 1), re.findall(r"\w+", slip)) for text, names in NAMES.items() for name in names
    for slip in slips(name)
]  # fmt: skip
QUANTITIES = [(right, wrong) for right, wrongs in UNITS.items() for wrong in wrongs]


def problems(text: str) -> list[Problem]:
    return [problem for problem in check_text(text).problems if not problem.note]


def is_gone(problem: Problem, text: str) -> bool:
    return (problem.key, problem.message) not in [(other.key, other.message) for other in problems(text)]


def test_there_are_many_mistakes_in_files_that_are_right() -> None:
    assert len(MISSPELT) + len(QUANTITIES) + len(WRITTEN) + len(LINES) >= 150
    assert not [problem for text in (TEMPLATE, LOOP, STUDY) for problem in problems(text)]


@pytest.mark.exhaustive(but=45)
@pytest.mark.parametrize("number", range(len(MISSPELT)), ids=["-".join(words) for *_, words in MISSPELT])
def test_the_name_that_is_meant_is_right(number: int) -> None:
    _, wrong, words = MISSPELT[number]
    found = problems(wrong)
    assert found
    for problem in found:
        meant = re.search(r"did you mean (\S+)\?", problem.hint)
        misspelt = [
            word for word in words if re.search(rf"\b{word}\b", f"{problem.key} {problem.message} {problem.got}")
        ]
        if meant is None:
            continue
        lines = wrong.splitlines()
        cured = [re.sub(rf"\b{misspelt[-1]}\b", meant[1], line) if n == problem.line else line
                 for n, line in enumerate(lines, 1)]  # fmt: skip
        assert is_gone(problem, "\n".join(cured)), str(problem)


@pytest.mark.parametrize(("right", "wrong"), QUANTITIES, ids=[wrong for _, wrong in QUANTITIES])
def test_the_unit_that_is_meant_is_right(right: str, wrong: str) -> None:
    assert f'"{right}"' in TEMPLATE
    text = TEMPLATE.replace(f'"{right}"', f'"{wrong}"', 1)
    (problem, *_) = problems(text)
    number, _, unit = wrong.partition(" ")
    whole = re.search(r'write "([^"]+)"|: "([^"]+)"', problem.hint)
    near = re.search(r"did you mean (\S+)\?|write a power as (\S+)|give it in (\S+)", problem.hint)
    assert whole or near, str(problem)
    cure = next(filter(None, whole.groups())) if whole else ""
    if near and not cure:
        meant = next(filter(None, near.groups()))
        named = re.search(r"unknown unit '(\w+)'", problem.message)
        cure = f"{number} {unit.replace(named[1], meant) if near[2] and named else meant}"
    assert is_gone(problem, TEMPLATE.replace(f'"{right}"', f'"{cure}"', 1)), str(problem)


@pytest.mark.parametrize(("right", "wrong"), WRITTEN, ids=[wrong for _, wrong in WRITTEN])
def test_what_a_hint_writes_is_right(right: str, wrong: str) -> None:
    assert right in TEMPLATE
    (problem, *_) = problems(TEMPLATE.replace(right, wrong, 1))
    cure = re.search(r'("[^"]+")', problem.hint)
    other = re.search(r"here that is (\w+)", problem.hint)
    assert cure or other, str(problem)
    written = cure[1] if cure else f'"{other[1]}"' if other else ""
    assert is_gone(problem, TEMPLATE.replace(right, written, 1)), str(problem)


@pytest.mark.parametrize(("right", "wrong"), LINES, ids=[wrong for _, wrong in LINES])
def test_the_line_that_a_hint_writes_is_right(right: str, wrong: str) -> None:
    text = TEMPLATE.replace(right, wrong, 1)
    (problem,) = problems(text)
    lines = text.splitlines()
    lines[problem.line - 1] = problem.hint.partition(": ")[2]
    assert is_gone(problem, "\n".join(lines)), str(problem)


@pytest.mark.exhaustive
def test_almost_every_misspelt_name_is_answered_by_a_name() -> None:
    hints = [" ".join(problem.hint for problem in problems(wrong)) for _, wrong, _ in MISSPELT]
    assert sum("did you mean" in hint for hint in hints) >= 0.95 * len(hints)


@pytest.mark.defect(
    "H920", before="to set the sum's unit, which was written, to 1", after="to set the filter's, which was not"
)
def test_the_unit_that_nobody_wrote_is_to_be_set() -> None:
    """A filter works in any unit, and so does a sum: the sum has been told its unit."""
    graph = Graph(
        name="",
        rate=1000,
        blocks={"filter": LowPass(), "sum": Sum(unit="V"), "one": Constant(unit="V")},
        wires=["filter.output -> sum.first", "one.output -> sum.second"],
    )
    with pytest.raises(ModelError) as caught:
        checked(graph)
    (problem,) = (each for each in caught.value.problems if "units" in each.message)
    assert problem.hint.startswith('set output_unit = "V" under [blocks.filter], or put a Gain')
