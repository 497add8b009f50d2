"""Codes of faults: every message of the source belongs to one, and no code is without messages."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from proofmass.blocks.declaration.explanations import EXPLANATIONS, code_of

ROOT = Path(__file__).parents[3]
MAKERS = (
    "Problem", "Refusal", "UnitError", "Missing", "RecordingError", "mismatch", "bad", "problem", "_problem",
    "problem_of_output", "._refuse", "refused", "refusal", "_refusal",
)  # fmt: skip
WITHOUT = {
    "and more problems",
    "{} has no {}",
    "{}: {}",
    "{} is {}",
    "column {}: {}",
    "{}, line 1: {}",
}  # no fault of its own, or told by other messages


def text_of(node: ast.expr) -> str | None:
    """A literal message, with {} for what is filled in; None where it comes from elsewhere."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return None


def named(tree: ast.AST) -> dict[str, list[ast.expr]]:
    """What is assigned to each name of a file, alone or among others."""
    found = defaultdict[str, list[ast.expr]](list)
    for node in ast.walk(tree):
        for target in node.targets if isinstance(node, ast.Assign) else ():
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = [*zip(target.elts, node.value.elts, strict=False)]
            for name, value in pairs:
                if isinstance(name, ast.Name):
                    found[name.id].append(value)
    return found


def given(call: ast.Call) -> list[ast.expr]:
    """The message that a problem or refusal is made with."""
    called = call.func.id if isinstance(call.func, ast.Name) else "." + getattr(call.func, "attr", "")
    return [k.value for k in call.keywords if k.arg == "message"] or call.args[:1] if called in MAKERS else []


def messages() -> Iterator[tuple[str, str]]:
    """Every literal message of a problem or refusal, with its place; where it has a name, all that has that name."""
    for folder in ("blocks", "graphs", "runner"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            text = file.read_text(encoding="utf-8")
            if not any(f"{maker.removeprefix('.')}(" in text for maker in MAKERS):
                continue
            tree = ast.parse(text)
            made = [one for node in ast.walk(tree) if isinstance(node, ast.Call) for one in given(node)]
            names = {one.id for one in made if isinstance(one, ast.Name)}
            made += (
                [value for name, values in named(tree).items() if name in names for value in values] if names else []
            )
            for one in made:
                if message := text_of(one):
                    yield message, f"{file.relative_to(ROOT)}:{one.lineno}"


@pytest.mark.friendly(38, "every message has a code")
def test_every_message_has_a_code_and_every_code_a_message() -> None:
    by_code: dict[str, list[str]] = defaultdict(list)
    for message, place in messages():
        by_code[code_of(message)].append(f"{place}: {message}")
    nameless = [entry for entry in by_code.pop("", []) if entry.split(": ", 1)[1] not in WITHOUT]
    assert not nameless, "add their words to a pattern in blocks/declaration/explanations.py"
    assert {entry.code for entry in EXPLANATIONS} == by_code.keys()


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("unknown unit 'degC'", "P0301"),
        ("mg is kg, not m/s^2", "P0302"),
        ("there is no such kind of block", "P0201"),
        ("MassSpringDamper has no such parameter", "P0202"),
        ("there is no block ghost", "P0205"),
        ("must be >= 2 and <= 32", "P0303"),
        ("must be an integer", "P0304"),
        ("mass.force is driven twice", "P0403"),
        ("algebraic loop: each of these outputs needs the one before it within the same tick", "P0404"),
        ("the rates have no common base rate within reach", "P0501"),
        ("the graph changed since the checkpoint", "P1001"),
        ("a converter of your own invention", ""),
    ],
)
def test_what_belongs_to_a_code(message: str, code: str) -> None:
    assert code_of(message) == code


def test_an_entry_is_a_title_a_cause_and_a_cure() -> None:
    codes = [entry.code for entry in EXPLANATIONS]
    assert codes == sorted(set(codes))
    for entry in EXPLANATIONS:
        assert entry.title[0].isupper()
        assert not entry.title.endswith(".")
        assert entry.cause.endswith(".")
        assert entry.cure.endswith(".")
