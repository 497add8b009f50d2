"""The public interface: every name has signature, types, words for each argument and field, errors and an example."""

import doctest
import inspect
import re
from collections.abc import Iterator
from typing import Any

import pytest

import proofmass
from docs.site.reference_fields import fields

NAMES = sorted(proofmass.__all__)
FUNCTIONS = [name for name in NAMES if inspect.isfunction(getattr(proofmass, name))]
CLASSES = [name for name in NAMES if inspect.isclass(getattr(proofmass, name))]
RAISE_NOTHING = {"check", "write_graph"}  # `check` returns what is wrong, and every graph can be written


def text_of(thing: object) -> str:
    return inspect.getdoc(thing) or ""


def public_members(name: str) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties of a class of its own."""
    for member, value in vars(getattr(proofmass, name)).items():
        if not member.startswith("_") and (inspect.isroutine(value) or isinstance(value, property)):
            yield f"{name}.{member}", value


def own_arguments(name: str) -> list[str]:
    """Return what a function, or the initialiser that a class has written itself, takes."""
    thing = getattr(proofmass, name)
    if inspect.isclass(thing):
        written = "__init__" in vars(thing) and "__dataclass_fields__" not in vars(thing)
        thing = thing.__init__ if written else None
    return [] if thing is None else [argument for argument in inspect.signature(thing).parameters if argument != "self"]


def test_there_are_names_of_every_sort() -> None:
    assert len(FUNCTIONS) > 20
    assert len(CLASSES) > 20
    assert sorted([*FUNCTIONS, *CLASSES]) == NAMES


@pytest.mark.parametrize("name", CLASSES)
def test_members_are_documented(name: str) -> None:
    assert [path for path, thing in public_members(name) if not text_of(thing).strip()] == []


@pytest.mark.parametrize("name", NAMES)
def test_every_argument_has_words(name: str) -> None:
    text = text_of(getattr(proofmass, name))
    assert [argument for argument in own_arguments(name) if f"`{argument}`" not in text] == []


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_has_words(name: str) -> None:
    assert [field.name for field in fields(getattr(proofmass, name)) if not field.meaning] == []


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_and_result_has_a_type(name: str) -> None:
    signature = inspect.signature(getattr(proofmass, name))
    missing = [argument.name for argument in signature.parameters.values() if argument.annotation is argument.empty]
    assert missing == []
    assert signature.return_annotation is not signature.empty


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS) - RAISE_NOTHING))
def test_errors_are_named(name: str) -> None:
    assert re.search("[Rr]aises `", text_of(getattr(proofmass, name)))


@pytest.mark.exhaustive(but=20)
@pytest.mark.parametrize("name", NAMES)
def test_the_example_runs(name: str) -> None:
    text = text_of(getattr(proofmass, name))
    example = doctest.DocTestParser().get_doctest(text, {"__name__": "__main__"}, name, None, None)
    assert any(part.want for part in example.examples), "an example shows what comes out"
    answers: list[str] = []
    doctest.DocTestRunner(verbose=False).run(example, out=answers.append)
    assert "".join(answers) == ""
