"""Affine forms of mantissas: errors of all rules against fractions, decisions and their conditions, what is refused."""

import operator
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, where
from proofmass.blocks.arithmetic.mantissa import Mantissa, Rounding, left_over
from proofmass.runner.fixed.affine import (
    ERROR,
    INPUT,
    REGISTER,
    AffineForms,
    AffineMantissa,
    AffineSymbol,
    NotAffineError,
)
from tests.by_hand.fixed_point import ROUNDINGS


def form(start: int = 0) -> AffineMantissa:
    return AffineForms().symbol(INPUT, 0, Fraction(start))


@pytest.mark.parametrize("rule", ROUNDINGS)
@pytest.mark.parametrize("factor", [1, 2, 3, 8, 12, 32])
@pytest.mark.parametrize("dropped", [1, 2, 5])
def test_errors_are_the_least_and_the_largest_of_all_numbers(rule: Rounding, factor: int, dropped: int) -> None:
    x = form()
    rounded = FixedValue(x * factor, dropped).to(Fixed(40, 0), rule).mantissa
    seen = set[Fraction]()
    for number in range(-130, 131):
        exact = Fraction(number * factor, 1 << dropped)
        seen.add(Fraction(FixedValue(number * factor, dropped).to(Fixed(40, 0), rule).mantissa) - exact)
    if seen == {0}:
        assert not x.of.errors
        return
    (error,) = x.of.errors
    assert (error.low, error.high) == (min(seen), max(seen))
    assert rounded.terms == {AffineSymbol(INPUT, 0): Fraction(factor, 1 << dropped), AffineSymbol(ERROR, 0): 1}


def test_all_bits_or_none_of_a_mask() -> None:
    x = form()
    for number in (-3, 0, 5):
        for mask in (0, -1):
            for operation in (operator.and_, operator.or_, operator.xor):
                found = operation(x, mask)
                value = (
                    found if isinstance(found, int) else found.constant + found.terms[AffineSymbol(INPUT, 0)] * number
                )
                assert value == operation(number, mask)


def test_it_is_a_mantissa() -> None:
    assert isinstance(form(), Mantissa)
    assert repr(2 * form() - 3) == "-3 + 2 input 0"


@pytest.mark.parametrize("start", [-7, 0, 1])
def test_it_is_true_where_its_number_is(start: int) -> None:
    assert bool(form(start)) == bool(start)


def test_the_same_number_rounds_alike() -> None:
    x = form()
    once, again = (FixedValue(3 * x + 1, 4).to(Fixed(16, 0), "half_up").mantissa for _ in range(2))
    assert once - again == 0
    assert len(x.of.errors) == 1
    other = FixedValue(3 * x + 1, 4).to(Fixed(16, 0), "floor").mantissa
    assert isinstance(other - once, AffineMantissa)
    assert len(x.of.errors) == 2


@pytest.mark.parametrize("start", [-7, 0, 5])
@pytest.mark.parametrize("compare", [operator.lt, operator.le, operator.gt, operator.ge, operator.eq, operator.ne])
def test_a_decision_is_the_same_wherever_its_condition_holds(compare: Callable[[Any, Any], bool], start: int) -> None:
    for number in (-7, 0, 3):
        for swapped in (False, True):
            x = form(start)
            outcome = compare(number, x) if swapped else compare(x, number)
            (condition,), values = x.of.conditions, range(-12, 13)
            apart = condition.form.constant
            alike = [v for v in values if (compare(number, v) if swapped else compare(v, number)) == outcome]
            kept = [v for v in values if (condition.low is None or v + apart >= condition.low)]
            kept = [v for v in kept if condition.high is None or v + apart <= condition.high]
            assert set(kept) <= set(alike)
            assert start in kept


def test_conditions_of_forms_that_lie_a_constant_apart_are_one() -> None:
    x = form()
    x.held(-10, 10, "")
    (x + 5).held(-10, 10, "")
    (condition,) = x.of.conditions
    assert (condition.low, condition.high) == (-10, 5)


def test_limits_and_wraps_are_the_form_itself_within_a_range() -> None:
    x = form(3)
    for value in (FixedValue(x).to(Fixed(4), overflow=way).mantissa for way in ("saturate", "wrap", "refuse")):
        assert value is x or (value - x) == 0
    (condition,) = x.of.conditions
    assert (condition.low, condition.high) == (-8, 7)
    turned = form(17).wrapped(-8, 7)
    assert turned.constant == -16
    assert [(c.low, c.high) for c in turned.of.conditions] == [(8, 23)]


def test_random_steps_are_their_forms() -> None:
    """The value of a step is that of its form with some errors within their ends, if its conditions hold."""
    rng = random.Random(4)
    for _ in range(200):
        a, b, c, d = (rng.randint(-60, 60) for _ in range(4))
        rules = rng.choices(ROUNDINGS, k=2)

        def step(x: Any, y: Any, a: int = a, b: int = b, c: int = c, d: int = d, rules: Any = rules) -> Any:
            first = FixedValue(a * x + b * y, 5).to(Fixed(12, 0), rules[0])
            second = where(first >= -40, FixedValue(c * first.mantissa + d * x, 6).to(Fixed(12, 0), rules[1]), first)
            return second.mantissa

        forms = AffineForms()
        x, y = forms.symbol(INPUT, 0), forms.symbol(REGISTER, 0)
        found = step(x, y)
        for _ in range(10):
            u, v = rng.randint(-30, 30), rng.randint(-30, 30)
            value = step(u, v)
            if isinstance(found, int):
                assert value == found
                continue
            at = {AffineSymbol(INPUT, 0): u, AffineSymbol(REGISTER, 0): v}
            rest = value - found.constant - sum(k * at[s] for s, k in found.terms.items() if s.kind != ERROR)
            parts = [(k, forms.errors[s.number]) for s, k in found.terms.items() if s.kind == ERROR]
            low = sum(min(k * e.low, k * e.high) for k, e in parts)
            high = sum(max(k * e.low, k * e.high) for k, e in parts)
            first = FixedValue(a * u + b * v, 5).to(Fixed(12, 0), rules[0]).mantissa
            if first >= -40:
                assert low <= rest <= high


@pytest.mark.parametrize(
    "operation",
    [
        lambda x: x * x,
        lambda x: x & 3,
        lambda x: x | 1,
        lambda x: 1 << x,
        lambda x: x >> x,
        lambda x: x // 3,
        lambda x: x % 4,
        lambda x: range(x),
        lambda x: int(x),
    ],
)
def test_what_is_not_affine_is_refused(operation: Callable[[Any], Any]) -> None:
    with pytest.raises(NotAffineError):
        operation(form())


def test_the_rest_of_a_search_counts_as_nothing() -> None:
    assert left_over(form(), 1, 1) == 0
