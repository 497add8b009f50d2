"""Integers as SMT words against Python's integers: the same steps on both, values compared by the solver."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, clip, stored, where, wrap
from proofmass.runner.rtl.proof.smt_integer import SmtInteger, Specification
from proofmass.runner.rtl.proof.smt_solver import SmtSolver

pytest.importorskip("bitwuzla")

STEPS: dict[str, Callable[[Any, Any], Any]] = {
    "sum": lambda a, b: a + b - 3,
    "difference": lambda a, b: 7 - a - b,
    "product": lambda a, b: a * b * -5,
    "power of two": lambda a, b: 8 * a + b * 4,
    "negated": lambda a, b: -a + abs(b),
    "bits": lambda a, b: (a & b) + (a | b) * 3 + (a ^ 13) + (b & 6) + ~a,
    "shifts": lambda a, b: (a << 3) + (b >> 2) + (a << (b & 3)) + (b >> (a & 7)) + (1 << (a & 3)) + (a << 0),
    "parts": lambda a, b: a // 4 + b % 8,
    "comparisons": lambda a, b: (a < b) + 2 * (a <= b) + 4 * (a > 3) + 8 * (b >= a) + 16 * (a == b) + 32 * (a != 5),
    "choice": lambda a, b: where(a > b, a - b, b),
    "held": lambda a, b: clip(a, -3, 20) + clip(7, b, a),
    "branches": lambda a, b: branching(a, b),
    "wrapped": lambda a, b: wrap(a * 3, Fixed(5)) + wrap(b, Fixed(3, 0, signed=False)),
    "rounded": lambda a, b: sum(
        FixedValue(a * b, 3).to(Fixed(5, 0), rounding, overflow).mantissa  # type: ignore[arg-type]
        for rounding in ("half_even", "half_up", "floor", "toward_zero")
        for overflow in ("saturate", "wrap")
    ),
}


def branching(a: Any, b: Any) -> Any:
    """Three branches, one of them on what another has decided already."""
    if a > 10 and not b < 0:
        a = a - 10
    if b < 0:
        return -a if a > 10 else b
    return a + b


@pytest.mark.parametrize("name", STEPS)
@settings(max_examples=12, deadline=None)
@given(a=st.integers(-40, 90), b=st.integers(-17, 30))
def test_words_are_what_integers_are(name: str, a: int, b: int) -> None:
    specification = Specification()
    inputs = [SmtInteger(specification, text, low, high) for text, low, high in (("a", -40, 90), ("b", -17, 30))]
    (value,) = specification.merged(lambda: [STEPS[name](*inputs)])
    solver = SmtSolver(["(declare-const a (_ BitVec 8))", "(declare-const b (_ BitVec 6))", *specification.lines])
    (found,) = solver.values({solver.read("a"): a, solver.read("b"): b}, [solver.read(value.text)])
    expected = int(STEPS[name](a, b))
    assert value.low <= expected <= value.high
    assert found == expected % (1 << value.width)


def test_what_is_known_beforehand_makes_no_branch() -> None:
    specification = Specification()
    a = SmtInteger(specification, "a", 0, 5)
    assert not a > 5
    assert a < 9
    assert a == a
    assert not specification.lines


def test_what_must_fit_is_noted_with_the_path_on_which_it_must() -> None:
    specification = Specification()
    a = SmtInteger(specification, "a", 0, 15)
    specification.merged(lambda: [stored(a, Fixed(4)) if a < 8 else 0])
    (obligation,) = specification.obligations
    solver = SmtSolver(["(declare-const a (_ BitVec 5))", *specification.lines])
    assert solver.prove(solver.read(obligation), [], 10.0, {}).verdict == "proved"
    specification.merged(lambda: [stored(a, Fixed(4))])
    assert solver.prove(solver.read(specification.obligations[1]), [], 10.0, {}).verdict == "refuted"


def test_what_is_no_integer_is_refused() -> None:
    specification = Specification()
    a = SmtInteger(specification, "a", 0, 15)
    with pytest.raises(TypeError, match="a float among integers"):
        a + 1.5
    with pytest.raises(TypeError, match="a signal bounds a loop or indexes a list"):
        range(a)  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="a division by 3"):
        a // 3
