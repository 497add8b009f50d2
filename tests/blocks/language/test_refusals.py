"""What `check` says of functions that no engine runs alike: construct, file, line, and what to write."""

import textwrap
from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.language.forms import problems_of
from proofmass.blocks.language.functions import plain_form
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main

FILE = '''
import math, numpy, os, random, time
from random import gauss
from typing import NamedTuple

from proofmass import Block, Buffer, Input, param

TABLE = [1.0, 2.0]
COUNTED = 0


class State(NamedTuple):
    count: int
    level: float


class Mine(Block):
    """A block of the user's own."""

    gain: float = param("1", "Gain.", default=2.0)
    input = Input("1", "Input.")
    line = Buffer("Line.", float, (4,))


def helped(a: float) -> float:
    {helper}
    return a


@Mine.output("1")
def level(p, x: State, line, input: float) -> float:
    """Level."""
    {output}


@Mine.update
def update(p, x: State, line, input: float) -> State:
    {update}


class Odd(NamedTuple):
    word: str


def starred(*values: float) -> float:
    return values[0]


def gathered(a: float, *, b: float = 1.0, **more: float) -> float:
    return a


def nothing(a: float) -> None:
    a = a + 1.0


def unknown(a: float) -> tuple[float, ...]:
    raise ValueError(a)


def refused(a: float):
    import cmath
    return a


def misnamed(a: float) -> "Unwritten":
    return 2.0 * a
'''
REGISTERS = '''
from typing import Any, NamedTuple

from proofmass import Block, Input
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue


class Held(NamedTuple):
    level: FixedValue


class Register(Block):
    """A register of the user's own."""

    input = Input("1", "Input.", FixedValue)


@Register.formats
def widths(p: Any) -> dict[str, Fixed]:
    return {"input": Fixed(16, 8), "x": Fixed(16, 8), "level": Fixed(16, 8)}


@Register.start
def begin(p: Any) -> Held:
    return Held(FixedValue(0, 8))


@Register.output("1")
def level(c: Any, x: Held) -> FixedValue:
    """Level."""
    print(x.level)
    return x.level


@Register.update
def update(c: Any, input: FixedValue) -> Held:
    return Held(input)
'''
GRAPH = """
name = "mine"
rate = "1 kHz"
samples = 5
wires = ["source.output -> mine.input"]
probes = ["mine.level"]
[blocks.source]
kind = "Constant"
[blocks.mine]
kind = "Mine"
"""


def problems(folder: Path, output: str = "", update: str = "", helper: str = "") -> list[str]:
    """What `check` says of a block with these statements."""
    given = {"output": output or "return x.level", "update": update or "return x", "helper": helper or "a = a + 1.0"}
    parts = {key: textwrap.indent(text, "    ").lstrip() for key, text in given.items()}
    path = folder / "mine.py"
    path.write_text(FILE.format(**parts))
    (folder / "mine.toml").write_text(GRAPH)
    found = check(read_graph(folder / "mine.toml", load_own_blocks(path)))
    lines = path.read_text().splitlines()
    for problem in found:
        assert problem.file == str(path)
        assert problem.got.lstrip("(")[:4] in lines[problem.line - 1]
    return [f"{problem.key}: {problem.message}; {problem.hint}" for problem in found]


OUTPUTS = {
    "print(x.level)\nreturn x.level": "print() is not compiled; record it",
    "with open('x') as file:\n    return 1.0": "with is not compiled",
    "text = open('x')\nreturn 1.0": "open() is not compiled; read files in `constants`",
    "try:\n    return 1.0\nexcept ValueError:\n    return 2.0": "try is not compiled; look at the numbers before",
    "return random.random()": "random.random() would make a run another each time; for noise name",
    "return gauss(0.0, 1.0)": "gauss() would make a run another each time",
    "return time.time()": "time.time() would make a run another each time; name the argument `time`",
    "os.system('ls')\nreturn 1.0": "os.system() reaches outside the block",
    "global COUNTED\nreturn 1.0": "global is not compiled; what a block remembers is its state",
    "return [u for u in line][0]": "a comprehension is not compiled; write a loop",
    "return numpy.sin(input)": "numpy.sin is not compiled; write math.sin",
    "return numpy.arctan2(input, 1.0)": "numpy.arctan2 is not compiled; write math.atan2",
    "return numpy.maximum(input, 0.0)": "numpy.maximum is not compiled; write max",
    "return numpy.clip(input, 0.0, 1.0)": "numpy.clip is not compiled; write min(max(x, low), high)",
    "return numpy.array([input])[0]": "numpy.array() is not compiled; declare a Buffer",
    "return sum(line)": "sum() of numbers is not compiled; add the entries up in a loop",
    "return (lambda u: u)(input)": "a lambda",
    "import math\nreturn math.sqrt(input)": "an import within a function",
    "text = f'{input}'\nreturn input": "a text",
    "return math.gamma(input)": "math.gamma() is not compiled; Python has its own",
    "return math.hypot(input, 1.0)": "math.hypot() is not compiled; write math.sqrt",
    "return math.sqr(input)": "math has no sqr; did you mean sqrt?",
    "return input.real": "a number has no real",
    "return p.gian * input": "MineParameters has no field gian; did you mean gain?",
    "return inptu": "there is no inptu; did you mean input?",
    "if input > 0.0:\n    return 1.0": "it does not always return a number; return a value on every path",
    "if input > 0.0:\n    u = 1.0\nreturn u": "u may have no value here; give it one before: u = 0.0",
    "u = x.count\nu = u * 0.5\nreturn u": "u is an integer elsewhere, and a number here",
    "return TABLE[0]": "a list cannot stand in a block's function; a table is a tuple of numbers",
    "return (math, 1.0)[1]": "the module math cannot be an entry",
    "return 123456789012345678901": "an integer of more than 64 bits",
    "return input if input > 0.0 else x.count": "a number in one case and an integer in another; write float",
    "line[0] = 1.0\nreturn 1.0": "it is only read here; buffers are changed in `update`",
    "return line[input]": "an index is an integer, and is given a number",
    "return (1.0, 2.0)[2]": "there is no entry 2 in a tuple of 2",
    "return input is None": "is is not compiled; compare with ==",
    "return input & 1": "bits of a number; the operators of bits are of integers",
    "return round(input, 2)": "round() is not compiled",
    "return level(p, x, line, input)": "level calls itself; write a loop",
    "return 'text'": "a text cannot stand in a block's function",
    "return None": "nothing is returned, and a number elsewhere or in the declaration",
    "return x": "what is returned is a number, and is given a State",
}
# Constructs, one after the other:
OUTPUTS |= {
    "return [input][0]": "a list is not compiled; declare a Buffer",
    "return {1.0}": "a set is not compiled; write a tuple",
    "return {1: input}[1]": "a dict is not compiled; write a tuple and an integer index",
    "return (u := input)": "an assignment within an expression is not compiled; give it a line of its own",
    "return (yield input)": "yield is not compiled; a block's function computes and returns",
    "yield from line\nreturn 1.0": "yield is not compiled; a block's function computes and returns",
    "del input\nreturn 1.0": "del is not compiled; leave the variable be",
    "def inner(a):\n    return a\nreturn 1.0": "a function within a function is not compiled; define it at the top",
    "class Inner:\n    pass\nreturn 1.0": "a class within a function is not compiled; define it at the top",
    "u = 1.0\ndef inner():\n    nonlocal u\nreturn u": "a function within a function",
    "async def inner():\n    pass\nreturn 1.0": "async is not compiled; a block's function computes and returns",
    "match x.count:\n    case 1:\n        pass\nreturn 1.0": "match is not compiled; write if and elif",
    "return helped(*line)": "* in a call; write the arguments one by one",
    "return State(*x).level": "* in a call; write the arguments one by one",
    "return starred(input)": "starred has * among its arguments; name them one by one",
    "return gathered(input)": "gathered has * among its arguments; name them one by one",
    "return line": "a list of values",
    "return input + line": "a list of values, where a number is needed",
    "a, b = input\nreturn a": "2 variables of a number",
    "u = nothing(input)\nreturn 1.0": "the function returns nothing; return a value from it",
    "return sum((x, x))": "sum() of a State; its entries must be numbers",
    "for i, u in enumerate(line, 0.5):\n    pass\nreturn 1.0": "enumerate from a number; it counts in integers",
    "return input @ input": "@ is of matrices; write loops over the entries",
    "return 1.0 if x.count in (1, 2) in (3, 4) else 0.0": "in within a chain of comparisons; join them by `and`",
    "return 1.0 if input in line else 0.0": "in, of a list of values; write a loop over its entries",
    "return line[1:][0]": "a part of a list; write a loop over its entries",
    "for u in input:\n    pass\nreturn 1.0": "a loop over a number; loops go over range(...), tuples and buffers",
    "return (0.5, x)[x.count]": "a tuple of 2 has no entries that an index may choose; make all its entries of",
    "return ~input": "~ of a number; ~ is of integers",
    "return input(1.0)": "a number cannot be called",
    "return input._replace(a=1.0)": "a number has no _replace",
    "return 1.0 if math.isclose(input) else 0.0": "isclose: missing a required argument: 'b'; its arguments: a, b",
    "return math.ldexp(input, 0.5)": "an argument of ldexp is an integer, and is given a number; write int(...)",
    "return Odd(1.0).word": "the field word has no type that can be compiled; declare it float, int or bool",
}
# Functions that Python has and compiled code has not, each with what to write:
OUTPUTS |= {
    "return input('?')": "a number cannot be called",
    "u = eval('1.0')\nreturn 1.0": "eval() is not compiled; write the expression",
    "exec('1.0')\nreturn 1.0": "exec() is not compiled; write the statements",
    "return sorted(line)[0]": "sorted() is not compiled; compare the entries in a loop",
    "u = map(abs, line)\nreturn 1.0": "map() is not compiled; write a loop",
    "u = filter(abs, line)\nreturn 1.0": "filter() is not compiled; write a loop",
    "return 1.0 if any(line) else 0.0": "any() is not compiled; write a loop, or conditions with or",
    "return 1.0 if all(line) else 0.0": "all() is not compiled; write a loop, or conditions with and",
    "return 1.0 if isinstance(input, float) else 0.0": "isinstance() is not compiled; a port or field has one type",
    "u = list(line)\nreturn 1.0": "list() is not compiled; declare a Buffer",
    "u = dict(a=1)\nreturn 1.0": "dict() is not compiled; write a tuple and an integer index",
    "u = str(input)\nreturn 1.0": "str() is not compiled; functions of a block work with numbers",
    "for u in reversed(line):\n    pass\nreturn 1.0": "reversed() is not compiled; write range(len(entries) - 1",
    "return math.lgamma(input)": "math.lgamma() is not compiled; Python has its own",
    "return math.fsum(line)": "math.fsum() is not compiled; add the entries up in a loop",
    "return math.dist((input,), (1.0,))": "math.dist() is not compiled; write math.sqrt of the sum of squares",
    "return math.frexp(input)[0]": "math.frexp() is not compiled; Python gives it as a tuple of two types",
    "return math.modf(input)[0]": "math.modf() is not compiled; write a - float(math.trunc(a))",
    "return math.remainder(input, 2.0)": "math.remainder() is not compiled; write a - b * float(round(a / b))",
    "return math.nextafter(input, 2.0)": "math.nextafter() is not compiled; write a * (1.0 + 2.0**-52)",
    "return math.ulp(input)": "math.ulp() is not compiled; write abs(a) * 2.0**-52",
    "return float(math.comb(5, 2))": "math.comb() is not compiled; compute it in `constants`",
    "return float(math.perm(5, 2))": "math.perm() is not compiled; compute it in `constants`",
}
UPDATES = {
    "return (1, 2.0)": "what is returned is a State, and is given a tuple of 2; return State(...)",
    "return State(1)": "State: missing a required argument: 'level'; its arguments: count, level",
    "return State(0.5, 1.0)": "the field count is an integer, and is given a number; write int(...)",
    "x.level = 1.0\nreturn x": "a field cannot be changed; return a new State(...) from update",
    "return x._replace(levle=1.0)": "State has no field levle; did you mean level?",
    "pass": "it does not always return a State",
    "line.append(1.0)\nreturn x": "a list of values has no append; declare a Buffer",
    "for i in range(input):\n    pass\nreturn x": "a range of numbers; range is of integers",
    "for i in range(2, input):\n    pass\nreturn x": "a range of numbers; range is of integers",
}


@pytest.mark.defect(
    "H2", before="open, try, random in a block: a hang, or another run each time", after="told by check"
)
@pytest.mark.defect("H3", before="print in a block: a hang that outlives SIGTERM", after="told by check, with the line")
@pytest.mark.parametrize("output", OUTPUTS, ids=[text.splitlines()[-1][:30] for text in OUTPUTS])
def test_an_output_that_cannot_be_compiled(output: str, tmp_path: Path) -> None:
    [problem] = problems(tmp_path, output)
    assert OUTPUTS[output] in problem
    assert problem.startswith("Mine.level: ")


@pytest.mark.parametrize("update", UPDATES, ids=[text.splitlines()[0][:30] for text in UPDATES])
def test_an_update_that_cannot_be_compiled(update: str, tmp_path: Path) -> None:
    [problem] = problems(tmp_path, update=update)
    assert UPDATES[update] in problem


def test_a_function_that_is_called_is_looked_into_and_all_is_told_at_once(tmp_path: Path) -> None:
    found = problems(
        tmp_path, "print(1)\nu = helped(input)\nreturn random.random()", helper="print(a)\na = time.time()"
    )
    assert [text.partition(";")[0] for text in found] == [
        "Mine.helped: print() is not compiled",
        "Mine.helped: time.time() would make a run another each time",
        "Mine.level: print() is not compiled",
        "Mine.level: random.random() would make a run another each time",
    ]


def test_a_helper_that_raises_in_place_of_a_list(tmp_path: Path) -> None:
    [problem] = problems(tmp_path, "u = unknown(input)\nreturn 1.0")
    assert problem == "Mine.unknown: raise in a function of a list of values; return a tuple"


@pytest.mark.parametrize(
    "output",
    ["return refused(input) if input > 0.0 else 1.0", "return min(1.0, refused(input))", "return refused(input).level"],
)
def test_what_comes_of_a_refused_function_is_not_refused_again(output: str, tmp_path: Path) -> None:
    [problem] = problems(tmp_path, output)
    assert problem.startswith("Mine.refused: an import within a function")


def test_a_result_that_is_named_by_an_unknown_word_is_taken_as_it_comes(tmp_path: Path) -> None:
    assert problems(tmp_path, "return misnamed(input)") == []


def test_a_block_in_fixed_point_is_looked_through_too(tmp_path: Path) -> None:
    (tmp_path / "registers.py").write_text(REGISTERS)
    [problem] = problems_of(load_own_blocks(tmp_path / "registers.py")["Register"])
    assert problem.message == "print() is not compiled"
    assert problem.line == REGISTERS.splitlines().index("    print(x.level)") + 1
    assert "breakpoint()" in problem.hint


def test_a_function_of_this_package_has_to_say_what_it_returns() -> None:
    def asked(a: float) -> float:
        return silent(a)

    def silent(a: float):  # type: ignore[no-untyped-def]
        return a

    silent.__module__ = "proofmass.silent"
    form = plain_form(asked, (float,), float)
    assert [problem.message for problem in form.problems] == ["silent() says no type of what it returns"]


@pytest.mark.parametrize("command", ["check", "run"])
def test_the_commands_say_it_and_do_not_run(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    problems(tmp_path, "print(input)\nreturn input")
    monkeypatch.chdir(tmp_path)
    assert main([command, "mine.toml", "--blocks", "mine.py"]) == 1
    told = "".join(capsys.readouterr())
    assert "mine.py:33: Mine.level: print() is not compiled" in told
    assert "breakpoint() and --engine python" in told


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x: State, line, input: float) -> float", "the first argument is the constants"),
        ("input: float) -> float", "the first argument is the constants"),
        ("p, x: State, speed: float) -> float", "cannot bind the argument"),
    ],
)
def test_a_first_argument_that_is_not_the_constants(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    given = {"output": "return 1.0", "update": "return x", "helper": "a = a + 1.0"}
    path.write_text(FILE.format(**given).replace("p, x: State, line, input: float) -> float", text))
    with pytest.raises(TypeError, match=message):
        load_own_blocks(path)
