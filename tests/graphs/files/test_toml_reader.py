"""A graph file: read, or refused with file, line, key and cure; what is in it is never run."""

import datetime
import math
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks import MassSpringDamper
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import graph_from, held_float, read_graph, read_graph_text
from proofmass.graphs.model.graph import Probe, Wire
from proofmass.graphs.model.limits import FILE_BYTES
from tests.by_hand.graph_texts import LIBRARY, SMALL, changed, line_of, problems_of


def said(*changes: tuple[str, str]) -> str:
    text = SMALL
    for old, new in changes:
        text = changed(text, old, new)
    return "\n".join(map(str, problems_of(text)))


@pytest.mark.exhaustive(but=35)
@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_the_library_is_read_with_its_place(path: Path) -> None:
    graph = read_graph(path)
    text = path.read_text(encoding="utf-8")
    assert graph.place.file == str(path)
    assert graph.place.folder == str(path.parent)
    for name in graph.blocks:
        header = f"[blocks.{name}]"
        written = header if header in text else f"\n{name} = {{ kind"  # the line before the inline table ends there
        assert graph.place.line(("blocks", name)) == line_of(text, written) + (written != header)
    for wire in graph.wires:
        assert graph.place.line(("wires", str(wire))) == line_of(text, f'"{wire}"')


def test_what_a_file_says_is_what_the_graph_holds() -> None:
    graph = read_graph_text(SMALL)
    assert graph.name == "a mass and a converter"
    assert graph.rate == Fraction(10_000)
    assert graph.duration == 1
    assert graph.wires[0] == Wire("mass.displacement", "readout.input")
    assert graph.probes == (Probe("adc.code"),)
    assert graph.blocks["mass"] == MassSpringDamper()


def test_inline_tables_and_dotted_keys_give_the_same_graph() -> None:
    text = """\
blocks = { push = { kind = "Constant", value = "1 uN", unit = "N" }, adc.kind = "AnalogToDigital", adc.bits = 16, \
mass = { kind = "MassSpringDamper" }, readout = { kind = "Gain", gain = 1e6, input_unit = "m", output_unit = "V" } }
name = "a mass and a converter"
rate = 10_000.0
duration = 1
probes = [{ signal = "adc.code" }]
wires = [ "push.output->mass.force", " mass.displacement  ->  readout.input ", "readout.output -> adc.voltage" ]
"""
    assert read_graph_text(text) == read_graph_text(SMALL)


def test_a_number_with_a_unit_needs_quotes() -> None:
    assert (
        said(('rate = "10 kHz"', "rate = 50 kHz  # fast"))
        == """\
model.toml:2: not TOML: Expected newline or end of document after a statement
  hint:     a number with a unit is written in quotes: rate = "50 kHz\""""
    )


@pytest.mark.parametrize(
    ("old", "new", "line", "hint"),
    [
        ('kind = "MassSpringDamper"', "kind = MassSpringDamper", 17, 'written in quotes: kind = "MassSpringDamper"'),
        ('value = "1 uN"', "value = -1.5e-3 uN", 13, 'written in quotes: value = "-1.5e-3 uN"'),
        ('value = "1 uN"', "value = .5 N", 13, 'written in quotes: value = ".5 N"'),
        ('value = "1 uN"', 'value = "1 uN', 13, "a quote is missing"),
        ("bits = 16", "bits 16", 27, "a line gives a key its value"),
        ("bits = 16", "bits =", 27, "the value is missing: bits = ..."),
        ("bits = 16", "bits = 16\nbits = 12", 28, "the same name is given twice"),
        ("[blocks.adc]", "[blocks.push]", 25, "the same name is given twice"),
        ('"push.output -> mass.force",', '"push.output -> mass.force"', 6, "look for a missing comma"),
        ('"push.output -> mass.force",', "push.output -> mass.force,", 5, "a wire is a text"),
        ('probes = ["adc.code"]', "probes = [adc.code]", 9, "look for a missing quote"),
    ],
)
def test_what_is_not_toml_is_explained(old: str, new: str, line: int, hint: str) -> None:
    problem = problems_of(changed(SMALL, old, new))[0]
    assert (problem.line, problem.file) == (line, "model.toml")
    assert problem.message.startswith("not TOML: ")
    assert hint in problem.hint


def test_a_file_that_ends_too_early_is_refused_at_its_last_line() -> None:
    assert [(p.line, p.message) for p in problems_of("a = 1\nwires = [\n\n")] == [(2, "not TOML: Invalid value")]
    assert [(p.line, p.message) for p in problems_of('a = 1\n\nb = """\nc\n')] == [(4, "not TOML: Unterminated string")]


@pytest.mark.parametrize("key", ["wires", "probes", "duration", "samples", "name", "description", "blocks"])
def test_a_key_after_the_first_block_is_told_where_it_belongs(key: str) -> None:
    value = {"wires": "[]", "probes": "[]", "duration": '"1 s"', "samples": "5", "blocks": "5"}.get(key, '"x"')
    assert (
        said(('kind = "MassSpringDamper"', f'kind = "MassSpringDamper"\n{key} = {value}'))
        == f"""\
model.toml:18: blocks.mass.{key}: MassSpringDamper has no such parameter
  got:      '{key}'
  hint:     after [blocks.mass] it belongs to that block: move it above the first [blocks. ...]"""
    )


@pytest.mark.parametrize("head", ["values", "integration", "measures.mean", "loops.main", "study", "tune"])
def test_keys_of_the_graph_after_another_table_count_and_are_told_where_they_belong(head: str) -> None:
    parts = re.split(r"^(?=wires = |probes = |\[blocks)", SMALL, maxsplit=3, flags=re.MULTILINE)
    first, wires, probes, rest = parts
    duration = 'duration = "1 s"\n'
    inner = {"measures.mean": 'signal = "adc.code"\nstatistic = "mean"\n', "loops.main": 'open_at = "adc.code"\n'}
    moved = "" if head == "values" else duration  # a value may not be called so, which has its own words
    own = "seed = 3\n" if head in ("study", "tune") else ""
    text = f"{first.replace(duration, '')}[{head}]\n{inner.get(head, '')}{own}{wires}{probes}{moved}{rest}"
    found = problems_of(text)
    keys = ["wires", "probes", *(["duration"] if moved else [])]
    assert [(p.key, p.message) for p in found] == [(f"{head}.{key}", "stands in the wrong table") for key in keys]
    assert found[0].line == text.count("\n", 0, text.index("wires = ")) + 1
    assert found[0].hint == f"after [{head}] it belongs to that table: move it above the first table"
    misspelt = problems_of(text.replace("-> adc.voltage", "-> adc.volts", 1))
    assert "adc.volts is neither an input nor a parameter" in [p.message for p in misspelt]


def test_ports_given_as_parameters_are_told_what_they_are() -> None:
    assert (
        said(("bits = 16", 'bits = 16\nvoltage = "5 V"\ncode = 3'))
        == """\
model.toml:28: blocks.adc.voltage: AnalogToDigital has no such parameter
  got:      'voltage'
  hint:     voltage is an input: connect it in wires, as in "block.output -> adc.voltage"
model.toml:29: blocks.adc.code: AnalogToDigital has no such parameter
  got:      'code'
  hint:     code is an output: record it in probes, as in "adc.code\""""
    )


def test_unknown_keys_at_the_top() -> None:
    assert (
        said(('name = "a mass and a converter"', 'nmae = "x"\nblock = 3\nfoo.bar = 1'))
        == """\
model.toml:1: nmae: unknown key
  got:      'nmae'
  hint:     did you mean name?
model.toml:2: block: unknown key
  got:      'block'
  hint:     did you mean blocks?
model.toml:3: foo: unknown key
  got:      'foo'
  hint:     the keys: blocks, description, duration, exports, formulas, integration, loops, measures, name, \
probes, rate, requirements, and 6 more."""
    )


def test_a_wrong_rate_is_told_beside_an_unknown_key() -> None:
    kind = 'kind = "MassSpringDamper"'
    told = said(('name = "a mass and a converter"', 'nmae = "x"'), (kind, f'{kind}\nrate = "1 kHz"'))
    assert "did you mean name?" in told
    assert "a continuous block has no rate" in told


def test_keys_of_studies_in_a_graph() -> None:
    name = 'name = "a mass and a converter"'
    assert "studies have runs: write runs = ... below [study], or in a study file" in said((name, f"{name}\nruns = 3"))
    told = said((name, f'{name}\ntolerances = {{ "adc.reference" = "1 %" }}'))
    assert "studies have spread: write [study.spread], or in a study file of its own" in told


def test_a_block_without_a_kind() -> None:
    assert "did you mean kind instead of knid?" in said(('kind = "Gain"', 'knid = "Gain"'))
    assert 'write [blocks.readout] and below it kind = "Gain"' in said(('kind = "Gain"', ""))
    assert 'write it in quotes, such as kind = "Gain"' in said(('kind = "Gain"', "kind = 5"))
    assert "blocks.more: a block needs a kind" in said(('kind = "Gain"', 'kind = "Gain"\n[blocks]\nmore = 3'))


def test_keys_of_the_wrong_type() -> None:
    text = "name = 5\ndescription = [1]\nrate = { a = 1 }\nduration = 2020-01-01\nwires = 3\nprobes = {}\nblocks = 3\n"
    assert [(p.line, p.key, p.message) for p in problems_of(text)] == [
        (1, "name", "must be a string"),
        (2, "description", "must be a string"),
        (3, "rate", "must be a rate"),
        (4, "duration", "must be a duration"),
        (5, "wires", "must be a list"),
        (6, "probes", "must be a list"),
        (7, "blocks", "must be a table"),
    ]


@pytest.mark.parametrize(
    "value", ["true", "nan", "[1]", "{ a = 1 }", "1979-05-27", "07:32:00", "1e999", "'5 A'", "''", "9" * 400]
)
def test_values_that_are_no_voltage(value: str) -> None:
    (problem,) = problems_of(changed(SMALL, "bits = 16", f"bits = 16\nreference = {value}"))
    assert (problem.file, problem.line, problem.key) == ("model.toml", 28, "blocks.adc.reference")
    assert problem.expected == "a number > 0, in V"


def test_every_problem_has_its_own_line() -> None:
    text = """\
rate = "fast"
seed = -1
wires = [
    "push.output -> mass.force",
    "nonsense",

    "more nonsense",
]
probes = ["mass",
    { signal = "mass.displacement", every = 0 }]

[blocks.push]
kind = "Constant"
value = "1 uN"   # of no dimension
rate = 0

[blocks.mass]
kind = "MassSpringDamper"
damping = -1
"stiffness" = "soft"
"""
    assert [(p.line, p.key) for p in problems_of(text)] == [
        (1, "rate"),
        (2, "seed"),
        (5, "wires.1"),
        (7, "wires.2"),
        (9, "probes.0"),
        (10, "probes.1"),
        (14, "blocks.push.value"),
        (15, "blocks.push.rate"),
        (19, "blocks.mass.damping"),
        (20, "blocks.mass.stiffness"),
    ]


def test_parameters_that_do_not_go_together_are_refused_with_their_line() -> None:
    text = SMALL + '\n[blocks.chips]\nkind = "ShiftRegister"\nlength = 5\ntaps = 576\n'
    found = [(p.line, p.key, p.message) for p in problems_of(text)]
    assert (32, "blocks.chips.taps", "does not go with the other parameters") in found


def test_a_file_that_is_not_there_and_a_folder(tmp_path: Path) -> None:
    for path, message in ((tmp_path / "none.toml", "No such file or directory"), (tmp_path, "Is a directory")):
        with pytest.raises(ModelError) as caught:
            read_graph(path)
        assert str(caught.value) == f"{path}: cannot be read: {message}"
    with pytest.raises(ModelError, match="cannot be read: embedded null byte"):
        read_graph("a\0b.toml")


def told(source: object) -> str:
    with pytest.raises(ModelError) as caught:
        graph_from(source)  # type: ignore[type-var]
    (problem,) = caught.value.problems
    return str(problem)


@pytest.mark.parametrize(
    ("missing", "hint"),
    [
        ("grap.toml", "did you mean {}/graph.toml?"),
        ("template.toml", "one of this name comes along: library:template"),
        ("nowhere/graph.toml", "there is no folder {}/nowhere"),
    ],
)
def test_a_missing_file_is_told_what_was_meant(missing: str, hint: str, tmp_path: Path) -> None:
    (tmp_path / "graph.toml").write_text(SMALL)
    assert graph_from(tmp_path / "graph.toml").name == "a mass and a converter"
    assert told(tmp_path / missing).endswith(f"No such file or directory\n  hint:     {hint.format(tmp_path)}")


def test_a_file_of_another_kind_is_told_which_graph_lies_beside_it(tmp_path: Path) -> None:
    data = tmp_path / "recorded.csv"
    data.write_text("time,force\n0,1\n")
    refused = f"{data}:1: this is not a graph file: it is not TOML\n  hint:     "
    assert told(data) == f"{refused}proofmass new sensor.toml writes a graph to start from"
    for name, meant in (("aa", "aa"), ("record", "record")):
        (tmp_path / f"{name}.toml").write_text(SMALL)
        assert told(data) == f"{refused}did you mean {tmp_path}/{meant}.toml?"


@pytest.mark.parametrize("data", [b"#" * (FILE_BYTES + 1), b"\xff" * (FILE_BYTES + 1), "# µ".encode() * FILE_BYTES])
def test_a_file_that_is_too_large(data: bytes, tmp_path: Path) -> None:
    file = tmp_path / "large.toml"
    file.write_bytes(data)
    hint = "put recorded data into a file of its own"
    assert told(file) == f"{file}: larger than 1024 KiB\n  hint:     {hint}"


def test_what_is_not_a_graph() -> None:
    assert told(5).startswith("this is not a graph\n  got:      5\n  hint:     name its file, or write Graph(")
    with pytest.raises(ModelError, match="this is a study, not a graph") as caught:
        read_graph_text('graph = "sensor.toml"\n[study]\nruns = 4\n')
    assert "proofmass montecarlo runs it; its graph is sensor.toml" in str(caught.value)


def test_own_blocks_are_used_only_when_they_are_given(tmp_path: Path) -> None:
    file = tmp_path / "own_blocks.py"
    file.write_text(
        "from proofmass.blocks.declaration.declare import block\n"
        '@block("V", voltage="V")\n'
        "def rectified(p, voltage: float) -> float:\n"
        '    """Absolute value."""\n'
        "    return abs(voltage)\n",
        encoding="utf-8",
    )
    text = 'rate = 1\n[blocks.b]\nkind = "Rectified"\n'
    with pytest.raises(ModelError, match="there is no such kind of block"):
        read_graph_text(text)
    own = load_own_blocks(file)
    assert type(read_graph_text(text, own=own).blocks["b"]) is own["Rectified"]


def test_a_failure_inside_a_blocks_own_check_is_a_problem() -> None:
    from proofmass.blocks.declaration.declare import Block, param

    class Fragile(Block):
        """A block whose check divides by its parameter."""

        width: float = param("1", "Width.", default=1.0)

    def requires(p: Any) -> Any:
        if 1.0 / p.width > 2.0:
            yield "width", "at least 0.5"

    Fragile.requires(requires)
    text = 'rate = 1\n[blocks.b]\nkind = "Fragile"\nwidth = 0\n'
    with pytest.raises(ModelError) as caught:
        read_graph_text(text, own={"Fragile": Fragile})
    said = str(caught.value).replace("float division", "division")  # as Python to 3.13 says
    assert said == "<text>:2: blocks.b: its parameters cannot be read: division by zero"


@pytest.mark.exhaustive
def test_problems_beyond_a_hundred_are_counted_as_more() -> None:
    text = "rate = 1\n" + "".join(f'[blocks.b{n}]\nkind = "Nothing"\n' for n in range(3000))
    found = problems_of(text)
    assert len(found) == 101
    assert str(found[-1]) == "model.toml:203: and more problems"


def test_dates_are_no_numbers() -> None:
    (problem,) = problems_of(changed(SMALL, "bits = 16", "bits = 2020-01-01"))
    assert problem.got == repr(datetime.date(2020, 1, 1))


@pytest.mark.parametrize("key", ["self", "class", "kind_", "__init__", "_parameters", "mass "])
def test_keys_that_python_keeps_for_itself_are_no_parameters(key: str) -> None:
    text = changed(SMALL, "bits = 16", f'"{key}" = 16')
    assert [(p.line, p.message) for p in problems_of(text)] == [(27, "AnalogToDigital has no such parameter")]


def test_a_key_of_the_graph_in_another_table_does_not_take_the_place_of_its_own() -> None:
    found = problems_of(SMALL.replace("[blocks", '[loops.main]\nopen_at = "adc.code"\nprobes = []\n[blocks', 1))
    assert [(p.key, p.message) for p in found] == [("loops.main.probes", "stands in the wrong table")]


@pytest.mark.defect("S1040", before="1e-400 in a file was read as 0", after="too small for a number")
@pytest.mark.parametrize(("number", "size"), [("1e-400", "small"), ("-0.1e-350", "small"), ("1e400", "large")])
def test_a_number_that_a_float_has_not_is_refused(number: str, size: str) -> None:
    text = f"{SMALL}reference = {number}\n"
    (problem,) = problems_of(text)
    assert f"too {size} for a number" in problem.message
    assert problem.line == line_of(text, "reference")


@pytest.mark.parametrize("zero", ["0.0", "-0e5", "0.000", "+0.0e-999"])
def test_zeros_are_numbers(zero: str) -> None:
    assert held_float(zero) == 0.0
    assert [held_float(text) for text in ("inf", "-inf", "5e-324")] == [math.inf, -math.inf, 5e-324]
