"""Ranges of worst cases: values at places, and the other places that a search tries, counted on paper."""

import pytest

from proofmass.runner.design.worst.ranges import Range, Tolerance


def choices(*values: float, nominal: float = 1.0) -> Range:
    return Range("a.value", "a.value", "1", nominal, values[0], values[-1], values)


def test_a_range_goes_from_its_nominal_value_to_either_end() -> None:
    wanted = Range("a.value", "a.value", "1", 1.0, 0.5, 3.0)
    assert [wanted.at(place) for place in (-1.0, -0.5, 0.0, 0.25, 1.0)] == [0.5, 0.75, 1.0, 1.5, 3.0]
    assert (wanted.others(0.25), wanted.others(-1.0)) == ([-0.25], [1.0])


def test_a_list_of_choices_has_each_at_its_place_and_the_nominal_one_in_the_middle() -> None:
    wanted = choices(1.0, 2.0, 5.0)
    assert [wanted.at(place) for place in (-1.0, 1e-9, 0.0, 1.0)] == [1.0, 2.0, 1.0, 5.0]
    assert wanted.others(-1.0) == [1e-9, 1.0], "each choice once"
    assert wanted.others(1.0) == [-1.0, 1e-9]
    assert wanted.others(0.0) == [1e-9, 1.0], "the nominal value is the first choice"


def test_of_a_long_list_nine_choices_are_tried_from_end_to_end() -> None:
    wanted = choices(*(float(number) for number in range(17)), nominal=8.0)
    tried = [wanted.at(place) for place in wanted.others(-1.0)]
    assert tried == [2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 16.0]


def test_a_tolerance_lies_about_what_a_formula_says_but_between_two_ends() -> None:
    part, width = Tolerance("a", "V", part=0.1), Tolerance("a", "V", width=0.5)
    assert part.about(-20.0, 7.0, 1.0) == pytest.approx(-18.0), "up, also of a negative number"
    assert width.about(-20.0, 7.0, -0.5) == pytest.approx(-20.25)
    ends = Tolerance("a", "V", ends=(-1.0, 4.0))
    assert [ends.about(99.0, 1.0, place) for place in (-1.0, -0.5, 0.0, 0.5, 1.0)] == [-1.0, 0.0, 1.0, 2.5, 4.0]
