"""What cannot be lowered is refused, with its line, the construct and what to write instead."""

import ast
import math
import traceback
import types
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.source import define
from proofmass.blocks.language.refusals import RefusedError
from proofmass.runner.program import lower as lowering
from proofmass.runner.program.form import FLOAT, Value
from proofmass.runner.program.lower import lower
from tests.by_hand.lowered import run

TABLE = (1.5, -2.0, 0.25)


class Pair(NamedTuple):
    first: float
    second: int = 7


def helper(a: float, b: float = 2.0) -> float:
    return a * b


def unknown(a: float) -> float:
    return a + missing  # type: ignore[name-defined]  # noqa: F821


def listed(a: float) -> float:
    return [a][0]


def texts(a: float) -> float:
    return a + "1"  # type: ignore[operator]


def wrong_field(a: float) -> float:
    return Pair(a).third  # type: ignore[attr-defined,no-any-return]


def wrong_fields(a: float) -> float:
    return Pair(a, 1, 2).first  # type: ignore[call-arg]


def wrong_entry(a: float) -> float:
    return TABLE[3]


def mixed_entries(n: int) -> Any:
    return (Pair(1.0), 2.0)[n]


def unassigned(a: float) -> float:
    if a > 0.0:
        b = 1.0
    while a < 0.0:
        a += c  # type: ignore[used-before-def]  # noqa: F821
        c = b  # noqa: F841
    return a


def not_ours(a: float) -> float:
    return math.gamma(a)


def bits_of_numbers(a: float) -> Any:
    return a & 1.0  # type: ignore[operator]


def itself(a: float) -> float:
    return itself(a - 1.0) if a > 0.0 else a


def raising(a: float) -> float:
    raise ValueError(a)


def with_else(n: int) -> int:
    for i in range(n):
        n += i
    else:
        n = 1
    return n


def other_type(a: float) -> Any:
    b: Any = a
    if a > 0.0:
        b = (1.0, 2.0)
    return b


def returns_others(a: float) -> Any:
    if a > 0.0:
        return 1.0, 2.0
    return a


def given_back(cells: list[float]) -> Any:
    return cells


def too_many(a: float) -> float:
    b, c, d = a, a  # type: ignore[misc]  # noqa: F841
    return b


def over_a_number(a: float) -> float:
    for b in a:  # type: ignore[attr-defined]
        a = b
    return a


def field_set(x: Any) -> float:
    x.first = 1.0
    return 1.0


def no_step(n: int) -> int:
    for i in range(0, n, 0):
        n += i
    return n


def starred(*values: float) -> float:
    return values[0]


def entry_set(a: float) -> float:
    (a, a)[0] = 1.0  # type: ignore[index]
    return a


def entry_changed(a: float) -> float:
    (a, a)[0] += 1.0  # type: ignore[index]
    return a


def another_list(n: int, cells: list[float], others: list[float]) -> float:
    some = cells
    if n > 0:
        some = others
    return some[0]


def unknown_part(n: int, cells: list[float]) -> float:
    return cells[n:][0]


def the_same(a: float) -> bool:
    return a is a


def one_or_the_other(n: int) -> Any:
    return (1.0, 2.0) if n > 0 else (1.0, 2.0, 3.0)


def entries_of_several_types(n: int) -> Any:
    return (Pair(1.0), (2.0,))[n]


def among_a_list(a: float, cells: list[float]) -> bool:
    return a in cells


def named_wrongly(a: float) -> float:
    return helper(a, c=2.0)  # type: ignore[call-arg]


def tuple_as_number(a: float) -> float:
    return (a, a) * a  # type: ignore[operator]


def entry_of_a_number(a: float) -> float:
    return a[0]  # type: ignore[index,no-any-return]


def wrong_name_of_a_module(a: float) -> float:
    return math.tau_two * a  # type: ignore[attr-defined,no-any-return]


def field_changed(x: Any) -> float:
    x.first += 1.0
    return 1.0


def while_with_else(n: int) -> int:
    while n > 0:
        n -= 1
    else:
        n = 1
    return n


def deleted(a: float) -> float:
    del a
    return 1.0


def counting(count: float) -> Any:
    def counted(a: float) -> float:
        nonlocal count
        count += a
        return count

    return counted


def made(text: str) -> Any:
    """A function of a text: tools that test rewrite assertions of files, and the rest need not run."""
    tree = ast.parse(text).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return define(tree, __file__, {"__name__": __name__})


REFUSED: list[tuple[Any, tuple[Any, ...], str]] = [
    (unknown, (1.0,), "there is no missing"),
    (listed, (1.0,), "a list"),
    (texts, (1.0,), "the str, where a number is needed"),
    (wrong_field, (1.0,), "a Pair has no third"),
    (wrong_fields, (1.0,), "Pair: too many positional arguments"),
    (wrong_entry, (1.0,), "there is no entry 3 among 3"),
    (mixed_entries, (1,), "a tuple of 2 has entries of several types"),
    (unassigned, (1.0,), "c may have no value here"),
    (not_ours, (1.0,), "gamma() is not compiled"),
    (bits_of_numbers, (1.0,), "bits of a number"),
    (itself, (1.0,), "itself calls itself"),
    (raising, (1.0,), "raise is not compiled"),
    (with_else, (1,), "else of a loop"),
    (other_type, (1.0,), "b is of another type elsewhere"),
    (returns_others, (1.0,), "it returns something else elsewhere"),
    (given_back, ([1.0],), "a list is returned"),
    (too_many, (1.0,), "3 variables of something else"),
    (over_a_number, (1.0,), "a loop over a value that is not a list"),
    (made("def beside(a):\n    for b, c in zip((a, a), a): pass"), (1.0,), "a loop over a value that is not a list"),
    (field_set, (Pair(1.0),), "a field cannot be changed"),
    (no_step, (3,), "a range of step 0"),
    (starred, (1.0,), "* among the arguments"),
    (entry_set, (1.0,), "it cannot be changed"),
    (entry_changed, (1.0,), "it cannot be changed"),
    (another_list, (1, [1.0], [2.0]), "some is another list elsewhere"),
    (unknown_part, (1, [1.0]), "a part of a list"),
    (the_same, (1.0,), "is is not compiled"),
    (one_or_the_other, (1,), "a tuple of 2 in one case and a tuple of 3 in another"),
    (entries_of_several_types, (1,), "a tuple of 2 has entries of several types"),
    (among_a_list, (1.0, [1.0]), "in is of tuples"),
    (helper, (1.0, 2.0, 3.0), "helper has 2 arguments, not 3"),
    (named_wrongly, (1.0,), "helper: got an unexpected keyword argument 'c'"),
    (tuple_as_number, (1.0,), "a tuple of 2, where a number is needed"),
    (entry_of_a_number, (1.0,), "a number has no entries"),
    (wrong_name_of_a_module, (1.0,), "math has no tau_two"),
    (field_changed, (Pair(1.0),), "a field cannot be changed"),
    (while_with_else, (1,), "else of a loop"),
    (counting(1.0), (1.0,), "nonlocal is not compiled"),
    (deleted, (1.0,), "del is not compiled"),
    (made("def spread(a):\n    return max(*a, 1.0)"), (1.0,), "* in a call"),
    (made("def ranged(a):\n    for n in range((1, 2)): pass"), (1.0,), "a tuple of 2, where a number is needed"),
    (made("def empty(n):\n    return ()[n]"), (1,), "a tuple of 0 has no entries that an index may choose"),
    (made("def adds_a_list(a):\n    return a + 1.0"), ([1.0],), "a list of values, where a number is needed"),
    (made("def asserting(a):\n    assert a"), (1.0,), "assert is not compiled"),
]

CONSTRUCTS = {
    "ListComp": "[b for b in (a, a)]",
    "GeneratorExp": "(b for b in (a, a))",
    "SetComp": "{b for b in (a, a)}",
    "DictComp": "{b: b for b in (a, a)}",
    "List": "[a]",
    "Set": "{a}",
    "Dict": "{a: a}",
    "Lambda": "lambda b: b",
    "NamedExpr": "(b := a)",
    "JoinedStr": "f'{a}'",
    "Starred": "",  # in calls and tuples: see `spread`
    "Yield": "yield a",
    "YieldFrom": "yield from a",
    "Try": "try: pass\n    finally: pass",
    "TryStar": "try: pass\n    except* ValueError: pass",
    "With": "with a: pass",
    "FunctionDef": "def b(): pass",
    "AsyncFunctionDef": "async def b(): pass",
    "ClassDef": "class B: pass",
    "Import": "import math",
    "ImportFrom": "from math import pi",
    "Global": "global b",
    "Nonlocal": "",  # within another function: see `counting`
    "Delete": "del a",
    "Match": "match a:\n        case 1: pass",
}


@pytest.mark.parametrize(("function", "given", "message"), REFUSED, ids=lambda case: getattr(case, "__name__", ""))
def test_what_is_refused_says_where_and_why(function: Any, given: Any, message: str) -> None:
    with pytest.raises(ModelError) as caught:
        run(function, *given)
    [problem] = caught.value.problems
    assert message in problem.message
    assert problem.file == __file__
    first = function.__code__.co_firstlineno
    assert first <= problem.line <= first + 8
    assert problem.hint


def refusals() -> dict[str, set[tuple[str, int]]]:
    """Every `raise refuse(...)` of lowering, by its text in the source, with the lines that it takes."""
    found: dict[str, set[tuple[str, int]]] = {}
    for file in sorted(Path(lowering.__file__).parent.glob("lower*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Raise) and ast.unparse(node.exc or node).startswith("refuse("):
                lines = range(node.lineno, (node.end_lineno or node.lineno) + 1)
                found[f"{file.name}:{node.lineno}: {ast.unparse(node)}"] = {(file.name, line) for line in lines}
    return found


def refused_at(function: Any, given: Any) -> tuple[str, int]:
    """File and line where lowering refuses a function."""
    with pytest.raises(ModelError) as caught:
        run(function, *given)
    refused = caught.value.__context__
    assert isinstance(refused, RefusedError)
    last = traceback.extract_tb(refused.__traceback__)[-1]
    return Path(last.filename).name, last.lineno or 0


def test_every_refusal_of_lowering_is_among_these() -> None:
    """Each place that refuses is reached by one of the functions above, whose text is asserted."""
    reached = {refused_at(function, given) for function, given, _ in REFUSED}
    places = refusals()
    assert len(places) >= 35
    assert [text for text, lines in places.items() if not lines & reached] == []


def test_every_construct_that_is_named_is_refused_by_its_name() -> None:
    assert list(CONSTRUCTS) == list(RefusedError.CONSTRUCTS)
    for name, text in CONSTRUCTS.items():
        if not text:
            continue
        said, hint = RefusedError.CONSTRUCTS[name]
        with pytest.raises(ModelError) as caught:
            lower(made(f"def using(a):\n    {text}"), [Value(FLOAT)])
        [problem] = caught.value.problems
        assert problem.message.startswith(said), name
        assert problem.hint == hint


def test_what_has_no_source_is_refused() -> None:
    nowhere = types.FunctionType(compile("lambda a: a", "<nowhere>", "eval").co_consts[0], {})
    with pytest.raises(ModelError, match="its source cannot be read"):
        lowering.lower(nowhere, [Value(FLOAT)])
    with pytest.raises(ModelError, match="is not a function"):
        lowering.lower(print, [Value(FLOAT)])
