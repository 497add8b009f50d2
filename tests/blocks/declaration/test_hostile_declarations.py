"""Declarations of a user's blocks that cannot be, and sources that are hard to find again."""

import math
from pathlib import Path
from typing import Any

import pytest

from proofmass import blocks
from proofmass.blocks import AnalogToDigital, FixedQuantiser, LowPass
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration import libraries
from proofmass.blocks.declaration.catalog import family_about, family_of, load_own_blocks, own_file
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.shown_units import as_written, display, displayed, long_time, prefix, relative_text
from proofmass.blocks.declaration.spelled_units import usual_unit
from proofmass.blocks.language.forms import form_of, problems_of
from tests.by_hand.functions import drive

HEAD = '''
import numpy
from random import random
from typing import NamedTuple

from proofmass import Block, Input, param


class Mine(Block):
    """A block of the user's own."""

    gain: float = param("1", "Gain.", default=2.0)
    input = Input("1", "Input.")


'''
LEVEL = '''
@Mine.output("1")
def level(p, input: float) -> float:
    """Level."""
    return p.gain * input
'''


def mine(folder: Path, text: str) -> type[Any]:
    (folder / "mine.py").write_text(HEAD + text)
    return load_own_blocks(folder / "mine.py")["Mine"]


def test_a_parameter_without_its_type_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(HEAD.replace("gain: float", "gain"))
    with pytest.raises(TypeError, match=r"Mine\.gain needs its type: write gain: float = param\(\.\.\.\)"):
        load_own_blocks(tmp_path / "mine.py")


def test_a_block_without_parameters_says_so(tmp_path: Path) -> None:
    text = HEAD.replace('    gain: float = param("1", "Gain.", default=2.0)\n', "")
    (tmp_path / "mine.py").write_text(text + LEVEL.replace("p.gain * ", ""))
    kind = load_own_blocks(tmp_path / "mine.py")["Mine"]
    with pytest.raises(TypeError, match=r"Mine has no parameters: write Mine\(\)"):
        kind(1.0)


def test_a_family_of_its_own(tmp_path: Path) -> None:
    kind = mine(tmp_path, LEVEL)
    assert (family_of(kind), family_about("own")) == ("own", "Blocks of your own file.")
    assert own_file(kind) == tmp_path / "mine.py"
    assert own_file(LowPass) is None
    assert family_about(family_of(LowPass)) == "Transfer functions, averages, decimators and demodulators."


@pytest.mark.parametrize("text", ["", "  "])
def test_a_count_that_is_empty_is_no_count(text: str) -> None:
    with pytest.raises(ModelError, match="must be an integer") as caught:
        AnalogToDigital(bits=text)  # type: ignore[arg-type]
    assert caught.value.problems[0].hint == "write its digits, such as 12"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("def update(p, input: float) -> int:\n    return 1", "what update returns is not declared"),
        (
            "class State(NamedTuple):\n    word: str\n\n\n@Mine.start\ndef begin(p) -> State:\n    return State('')\n\n"
            "\n@Mine.update\ndef update(p, x: State, input: float) -> State:\n    return x",
            "the field word of State has a type that no engine holds",
        ),
        (
            "class Constants(NamedTuple):\n    a: float\n\n\n@Mine.constants\ndef constants(p) -> Constants:\n"
            "    global drawn\n    drawn = 1\n    return Constants(p.gain)",
            "a function of a block changes nothing outside of it",
        ),
        pytest.param(
            "class Constants(NamedTuple):\n    a: float\n\n\n@Mine.constants\ndef constants(p) -> Constants:\n"
            "    return Constants(p.gain * numpy.random.random())",
            "numpy.random.random() would make a run another each time",
            marks=pytest.mark.defect("S696", before="NumPy's dice in constants: another run each time", after="told"),
        ),
        pytest.param(
            "class Constants(NamedTuple):\n    a: float\n\n\n@Mine.constants\ndef constants(p) -> Constants:\n"
            "    return helped(p.gain)\n\n\ndef helped(gain):\n    return Constants(gain * random())",
            "random() would make a run another each time",
            marks=pytest.mark.defect(
                "S695", before="`from random import random` in constants: another run each time", after="told by check"
            ),
        ),
    ],
    ids=["no record", "a text", "global", "numpy", "random"],
)
def test_functions_that_no_engine_runs_alike(text: str, message: str, tmp_path: Path) -> None:
    decorated = text if text.startswith("class") else f"@Mine.update\n{text}"
    level = LEVEL.replace("p, input: float", "c, input: float") if "constants" in text else LEVEL
    problems = problems_of(mine(tmp_path, decorated + "\n\n" + level.replace("p.gain * input", "input")))
    assert message in [problem.message for problem in problems]


def test_a_source_with_two_functions_in_a_line_and_one_that_python_leaves_out(tmp_path: Path) -> None:
    """The function that the line of a message is looked up in is the one that runs."""
    text = "first, second = (lambda a: a), (lambda a: 2.0 * a)\nalone = lambda a: a + 1.0\n\n"
    text += "if 0:\n    def never():\n        return 1.0\n\n"
    kind = mine(tmp_path, text + LEVEL.replace("p.gain * input", "alone(input) + first(input)"))
    (problem,) = problems_of(kind)
    assert problem.message == "its line has several lambdas, or its file has changed since it was loaded"
    assert problem.line == (HEAD + text).splitlines().index(text.splitlines()[0]) + 1


@pytest.mark.defect("C882", before="AttributeError inside proofmass", after="constants need their type")
def test_constants_without_a_declared_type(tmp_path: Path) -> None:
    text = "@Mine.constants\ndef constants(p):\n    return p\n\n" + LEVEL
    (problem,) = problems_of(mine(tmp_path, text))
    assert (problem.message, problem.key) == ("what constants returns is not declared", "Mine.constants")


@pytest.mark.parametrize("library", ["pyarrow", "h5netcdf"])
def test_what_is_not_installed_says_what_brings_it(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(libraries, "installed", lambda name: False)
    extra = libraries.LIBRARIES[library].extra
    with pytest.raises(libraries.MissingLibraryError, match=f"{library} is not installed: it makes maps") as caught:
        libraries.need(library, purpose="maps")
    assert caught.value.problems[0].hint == f'pip install "proofmass[{extra}]"'
    error = libraries.told(ImportError("none", name=f"{library}.parts"))
    assert error is not None
    assert f"{library} is not installed" in str(error)
    assert libraries.told(ImportError("none", name="another")) is None
    assert libraries.told(ImportError("none")) is None


def test_a_quantiser_that_refuses_gives_what_does_not_fit() -> None:
    block = FixedQuantiser(output_format=Fixed(8, 4), overflow="refuse")
    assert drive(block, [{"input": 100.0}, {"input": -7.5}]) == [{"output": 1600}, {"output": -120}]


def test_numbers_in_the_unit_that_is_wanted() -> None:
    """1 rad/s is 180 3600 / pi deg/h."""
    factor, unit = display("rad/s", "deg/h", 1e-5)
    assert (factor, unit) == (pytest.approx(180.0 * 3600.0 / math.pi, rel=1e-14), "°/h")
    assert display("V", "", 2.5e-3) == (pytest.approx(1e3), "mV")
    assert displayed(1e-5, "rad/s", "deg/h", 4) == "2.063 °/h"
    assert displayed(2.5e-3, "V", "") == "2.5 mV"
    assert displayed(0.25, "%", "1") == "0.0025"
    assert prefix("mV", 5.0) == (1.0, "mV")
    assert prefix("mV", 2e-3) == (pytest.approx(1e3), "µV")
    assert prefix("kHz", 2e-3) == (pytest.approx(1e3), "Hz")
    assert as_written("", 5400.0, "s") == "1.5 h"
    assert [usual_unit(*one) for one in (("V/m", 2e7), ("kg", 5e-8), ("V", math.inf))] == ["MV/m", "ug", "V"]
    assert [usual_unit("V", size) for size in (0.999, 1.0, 2.0, 600.0, 999.0, 1000.0)] == ["mV", *["V"] * 4, "kV"]


def test_long_times_and_parts_of_a_whole() -> None:
    assert [long_time(s) for s in (3600.0, 86400.0, 31557600.0, 3 * 31557600.0)] == ["1 h", "1 d", "1 year", "3 years"]
    assert [relative_text(part) for part in (0.0, 8e-4, -8e-4, 1e-3, 0.025)] == [
        "0",
        "800 ppm",
        "-800 ppm",
        "0.1 %",
        "2.5 %",
    ]


def test_a_helper_that_has_no_source_is_let_pass(tmp_path: Path) -> None:
    text = "exec('def made(gain): return 2.0 * gain')\n\n\nclass Constants(NamedTuple):\n    a: float\n\n\n"
    text += "@Mine.constants\ndef constants(p) -> Constants:\n    return Constants(made(p.gain))\n"
    kind = mine(tmp_path, text + LEVEL.replace("p, input", "c, input").replace("p.gain", "c.a"))
    assert problems_of(kind) == []


def test_annotations_in_quotes_and_lists_of_numbers(tmp_path: Path) -> None:
    text = "from __future__ import annotations\n" + HEAD.replace(
        '    gain: float = param("1", "Gain.", default=2.0)\n',
        '    taps: tuple[float, ...] = param("1", "Taps.", default=(1.0, 2.0))\n',
    )
    text += "class State(NamedTuple):\n    level: float\n\n\ndef twice(a: float) -> float:\n    return 2.0 * a\n\n\n"
    text += "@Mine.update\ndef update(p, x: State, input: float) -> State:\n    return State(x.level + input)\n\n\n"
    level = LEVEL.replace("    return p.gain * input", "    return twice(sum_of(p.taps)) * input")
    text += (
        "def sum_of(taps):\n    total = 0.0\n    for tap in taps:\n        total += tap\n    return total\n\n" + level
    )
    (tmp_path / "mine.py").write_text(text)
    kind = load_own_blocks(tmp_path / "mine.py")["Mine"]
    assert problems_of(kind) == []
    form = form_of(kind, kind.output_functions["level"])
    assert form is not None
    assert form.function is not None
    assert form.function(kind(taps=(0.5, 3.0)), 2.0) == 2.0 * 3.5 * 2.0


def test_a_name_of_no_block_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="gian"):
        blocks.gian  # noqa: B018


@pytest.mark.defect("S810", before="param(0.1, 'V') and Input('V'): Python's own words", after="the line to write")
@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('param("1", "Gain.", default=2.0)', 'param(0.1, "V")', r"'default': write gain: float = param\("),
        ('param("1", "Gain.", default=2.0)', 'param("V", 2.0, 3.0)', r"too many .*write gain: float = param"),
        ('param("1", "Gain.", default=2.0)', 'param(0.1, "V", default=2.0)', r"gain: the unit comes first.* got 0.1"),
        ('Input("1", "Input.")', 'Input("1")', r"'doc': write voltage = Input\("),
        ('Input("1", "Input.")', 'Input(1.0, "V")', r"input: the unit comes first, as a text .* got 1.0"),
        ('Input("1", "Input.")', 'Buffer("Line.")', r"'dtype': write line = Buffer\("),
        ('@Mine.output("1")', "@Mine.output(1.0)", r"level: the unit comes first"),
    ],
)  # fmt: skip
def test_a_declaration_written_wrongly_has_the_line_to_write(old: str, new: str, told: str, tmp_path: Path) -> None:
    assert old in HEAD + LEVEL
    (tmp_path / "mine.py").write_text((HEAD.replace("Block,", "Block, Buffer,") + LEVEL).replace(old, new))
    with pytest.raises(TypeError, match=told):
        load_own_blocks(tmp_path / "mine.py")


@pytest.mark.defect(
    "S811", before="@requires that yields no pairs: an error inside proofmass", after="its line, a cure"
)
@pytest.mark.parametrize(
    ("body", "got"),
    [
        ('yield "gain"', "'gain'"),
        ('yield "gian", "less than 1"', "('gian', 'less than 1')"),
        ("yield 1, 2", "(1, 2)"),
        ("return None", "None"),
        ('return "gain"', "'gain'"),
    ],
)
def test_requirements_that_are_no_pairs_are_told_of_the_block(body: str, got: str, tmp_path: Path) -> None:
    kind = mine(tmp_path, f"@Mine.requires\ndef together(p):\n    {body}\n\n{LEVEL}")
    with pytest.raises(ModelError) as caught:
        kind()
    (problem,) = caught.value.problems
    assert (problem.got, problem.hint) == (got, 'write yield "gain", "less than 1"')
    assert (problem.file, problem.line) == (str(tmp_path / "mine.py"), HEAD.count("\n") + 1)
    assert problem.code
