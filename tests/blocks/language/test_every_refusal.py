"""Every refusal of a function has a test on its text: of what users write, and of what is lowered for the library."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from proofmass.blocks.language import operations
from proofmass.blocks.language.refusals import RefusedError

ROOT = Path(__file__).parents[3]
TESTS = [ROOT / "tests" / "blocks" / "language" / "test_refusals.py"]
LOWERING = [ROOT / "tests" / "runner" / "program" / "test_lower_refusals.py"]


def refusals(files: Iterator[Path]) -> Iterator[tuple[str, str]]:
    """Where something is refused, and the longest part of the message that is always the same."""
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Name)
                and node.func.id in ("refuse", "RefusedError")
            ):
                texts = [part for argument in node.args[1:2] for part in _parts(argument)]
                if any(text.strip() for text in texts):
                    yield f"{path.name}:{node.lineno}", max(texts, key=len).strip()


def _parts(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    if isinstance(node, ast.JoinedStr):
        yield from (text for part in node.values for text in _parts(part))


def untested(files: Iterator[Path], tests: list[Path]) -> list[str]:
    told = "\n".join(path.read_text(encoding="utf-8") for path in tests)
    return [f"{where}: {text}" for where, text in refusals(files) if text not in told]


def test_what_users_write() -> None:
    assert untested((ROOT / "blocks" / "language").glob("*.py"), TESTS) == []


def test_what_is_lowered() -> None:
    assert untested((ROOT / "runner" / "program").glob("lower*.py"), LOWERING) == []


@pytest.mark.parametrize("construct", sorted(RefusedError.CONSTRUCTS))
def test_constructs(construct: str) -> None:
    message, hint = RefusedError.CONSTRUCTS[construct]
    assert hint
    assert message in TESTS[0].read_text(encoding="utf-8"), f"{construct}: {message}"


def test_every_function_with_another_to_write_is_refused_somewhere() -> None:
    text = TESTS[0].read_text(encoding="utf-8")
    assert [f.__name__ for f in operations.INSTEAD if not re.search(rf"\b{f.__name__}\(", text)] == []
