"""Constants in the types that they are declared with."""

from typing import NamedTuple

import pytest

from proofmass.runner.plan.constants import typed


class Constants(NamedTuple):
    gain: float
    mask: int
    taps: tuple[float, ...]


def test_each_field_has_its_type() -> None:
    made = typed(Constants(2, True, (1, 2)))
    assert made == (2.0, 1, (1.0, 2.0))
    assert [type(value) for value in (*made[:2], *made.taps)] == [float, int, float, float]
    assert typed(None) is None


@pytest.mark.parametrize("mask", [2**63, -(2**63) - 1])
def test_an_integer_of_more_than_64_bits_is_refused(mask: int) -> None:
    assert typed(Constants(1.0, mask - 1 if mask > 0 else mask + 1, ())).mask in (2**63 - 1, -(2**63))
    with pytest.raises(OverflowError, match=f"{mask} does not fit 64 bits"):
        typed(Constants(1.0, mask, ()))


@pytest.mark.parametrize(("mask", "taps"), [(2.7, ()), ("2", ()), (2, 1.0), ((2,), ())])
def test_a_value_of_another_type_is_refused(mask: object, taps: object) -> None:
    assert typed(Constants(1.0, 2.0, [1, 2])).taps == (1.0, 2.0)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="must be of type"):
        typed(Constants(1.0, mask, taps))  # type: ignore[arg-type]
