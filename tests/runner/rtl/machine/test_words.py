"""Widths of words, and names that every Verilog takes."""

import pytest

from proofmass.runner.rtl.machine.words import VerilogNames, Word


@pytest.mark.parametrize(
    ("low", "high", "width", "signed"),
    [
        (0, 1, 1, False),
        (0, 255, 8, False),
        (0, 256, 9, False),
        (-1, 0, 1, True),
        (-128, 127, 8, True),
        (-3, 200, 9, True),
    ],
)
def test_a_word_has_the_bits_that_its_range_needs(low: int, high: int, width: int, signed: bool) -> None:
    word = Word(low, high)
    assert (word.width, word.signed) == (width, signed)
    patterns = {value & ((1 << width) - 1) for value in range(low, high + 1)}
    assert len(patterns) == high - low + 1


def test_a_word_is_written_as_a_format() -> None:
    assert str(Word(-8, 7, 2)) == "(4, 2)"
    assert str(Word(0, 1022)) == "(10, 0) unsigned"
    assert Word(0, 9).holds(0, 9)
    assert not Word(0, 9).holds(-1, 3)


def test_names_are_given_once_and_are_no_keywords() -> None:
    names = VerilogNames(["clock"])
    said = ["x.total", "history[3]", "output", "clock", "always", "x_axis.adc.code", "x_axis_adc.code", "3rd", "größe"]
    given = [names.add(text) for text in said]
    assert given[:6] == ["total", "history_3", "output_", "clock_", "always_", "x_axis_adc_code"]
    assert given[6:] == ["x_axis_adc_code_", "_3rd", "gr__e"]
    assert len(set(given)) == len(given)
