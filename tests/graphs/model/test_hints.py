"""Sizes of ports in words, and the causes of what is not TOML."""

import pytest

from proofmass.graphs.model.hints import counted, syntax_hint


@pytest.mark.parametrize(
    ("shape", "words"), [((), "a single value"), ((16,), "a vector of 16 entries"), ((2, 3), "a vector of 6 entries")]
)
def test_shapes_in_words(shape: tuple[int, ...], words: str) -> None:
    assert counted(shape) == words


@pytest.mark.parametrize(
    ("message", "line", "hint"),
    [
        ("Expected newline", "gain = 5 V/m # five", 'a number with a unit is written in quotes: gain = "5 V/m"'),
        ("Expected newline", "gain = +.5%", 'a number with a unit is written in quotes: gain = "+.5%"'),
        ("Invalid value", "kind = Gain", 'a text is written in quotes: kind = "Gain"'),
        (
            "Unclosed array",
            "[blocks.adc]",
            "a list ends with ], with commas between its entries: look for a missing comma or bracket, here or above",
        ),
        (
            "Duplicate inline table key 'a'",
            "a = { a = 1, a = 2 }",
            "the same name is given twice: rename or remove one of them",
        ),
        ("Anything", "", 'a line gives a key its value, as in bits = 16 or kind = "Gain"'),
    ],
)
def test_causes_of_what_is_not_toml(message: str, line: str, hint: str) -> None:
    assert syntax_hint(message, line) == hint
