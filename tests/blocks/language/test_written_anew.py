"""Functions as users write them, read and written anew, against the functions themselves in Python."""

import math
import sys
from collections.abc import Callable
from itertools import product
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

from proofmass.blocks.language.functions import plain_form
from proofmass.blocks.language.values import Record
from tests.blocks.language import written_functions as functions

NUMBERS = (-2.5, -1.0, 0.0, 0.5, 3.0)


@pytest.mark.parametrize("function", functions.COMPILED, ids=lambda function: function.__name__)
def test_what_can_be_compiled_is_what_python_does(function: Callable[..., Any]) -> None:
    result = int if function is functions.counted else float
    form = plain_form(function, (float, float), result)  # type: ignore[arg-type]
    assert [str(problem) for problem in form.problems] == []
    assert form.function is not None
    for a, b in product(NUMBERS, repeat=2):
        assert form.function(a, b) == function(a, b)
        assert type(form.function(a, b)) is result


@pytest.mark.parametrize("function", functions.RAISING, ids=lambda function: function.__name__)
def test_what_raises_still_raises(function: Callable[[float], Any]) -> None:
    form = plain_form(function, (float,), None)  # type: ignore[arg-type]
    assert [str(problem) for problem in form.problems] == []
    assert form.function is not None
    assert form.function(2.0) == function(2.0)
    with pytest.raises((ValueError, AssertionError), match="below zero"):
        form.function(-1.0)


def test_a_function_that_only_raises_has_a_type_all_the_same() -> None:
    form = plain_form(functions.always, (float,), None)  # type: ignore[arg-type]
    assert (form.problems, form.result) == ([], int)
    assert form.function is not None
    with pytest.raises(ValueError, match=r"never 2\.0"):
        form.function(2.0)


def test_two_functions_of_one_name_stay_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, text in (("early", "return 2.0 * a"), ("later", "return a - 1.0")):
        (tmp_path / f"{name}_of_two.py").write_text(f"def taken(a: float) -> float:\n    {text}\n")
    (tmp_path / "uses_of_two.py").write_text(
        "import early_of_two\nimport later_of_two\n\n\n"
        "def used(a: float) -> float:\n    return early_of_two.taken(a) * later_of_two.taken(a)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    import uses_of_two  # type: ignore[import-not-found]

    try:
        form = plain_form(uses_of_two.used, (float,), float)
        assert form.function is not None
        assert form.function(4.0) == 8.0 * 3.0
    finally:
        for name in ("early_of_two", "later_of_two", "uses_of_two"):
            del sys.modules[name]


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (functions.of_a_class, "Named.text is not compiled"),
        (functions.of_a_label, "a Labelled cannot stand in a block's function"),
        (functions.starred, "max() is not compiled"),
        (functions.of_a_module, "the module math cannot be an entry"),
        (functions.below_a_text, "a text cannot stand in a block's function"),
        (functions.at_a_half, "an index is an integer, and is given a number"),
        (functions.perhaps, "a text"),
        (functions.of_what_was_refused, "a text"),
        (functions.grown, "a field cannot be changed"),
        (functions.put, "a tuple of 3 cannot be changed"),
    ],
    ids=lambda one: getattr(one, "__name__", ""),
)
def test_what_cannot_be_compiled_is_told_once(function: FunctionType, message: str) -> None:
    kinds = (Record(functions.Pair),) if function is functions.grown else (float,)
    form = plain_form(function, kinds, float)
    (problem,) = form.problems
    assert message in problem.message
    assert problem.file == functions.__file__


def test_what_is_no_function_is_told() -> None:
    (problem,) = plain_form(math.floor, (float,), float).problems  # type: ignore[arg-type]
    assert str(problem).startswith("a builtin_function_or_method is not a function")
