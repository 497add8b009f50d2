"""Problems are rendered in one place: what, where, got, expected, hint."""

from collections.abc import Collection

import pytest

from proofmass.blocks.declaration.problem import (
    ModelError,
    Problem,
    Refusal,
    _one_slip,
    collecting,
    did_you_mean,
    nearest,
    shown,
    under,
)

FEW, MANY = [f"input_{n:02}" for n in range(14)], [f"input_{n:04}" for n in range(3000)]


def test_every_part_is_rendered_in_its_place() -> None:
    problem = Problem(
        message="must be > 0",
        file="sensor.toml",
        line=12,
        key="blocks.mass.stiffness",
        got="-3.0 N/m",
        expected="a number > 0, in N/m",
        hint="leave out the sign",
    )
    assert str(problem) == (
        "sensor.toml:12: blocks.mass.stiffness: must be > 0\n"
        "  got:      -3.0 N/m\n"
        "  expected: a number > 0, in N/m\n"
        "  hint:     leave out the sign"
    )


def test_empty_parts_are_left_out() -> None:
    assert str(Problem(message="the graph has no rate")) == "the graph has no rate"
    assert str(Problem(message="is not used", key="adc.number", note=True)) == "note: adc.number: is not used"
    assert str(Problem(message="not text", file="a.toml")) == "a.toml: not text"


def test_a_place_is_added_and_never_taken_away() -> None:
    problem = Problem(message="m", file="a.toml", line=3)
    assert problem.at("b.toml", 4) == Problem(message="m", file="b.toml", line=4)
    assert problem.at() == problem


def test_as_data() -> None:
    assert Problem(message="m", key="k", line=2).as_data() == {
        "code": "",
        "file": "",
        "line": 2,
        "key": "k",
        "message": "m",
        "got": "",
        "expected": "",
        "hint": "",
        "note": False,
    }


def test_two_ways_to_a_place_are_one_problem() -> None:
    here, there = (Problem(message="must be > 0", key="mass", path=path) for path in (("blocks", "mass"), ("mass",)))
    assert list(dict.fromkeys([here, there])) == [here]


def test_an_error_lists_every_problem() -> None:
    error = ModelError([Problem(message="first", got="1"), Problem(message="second")])
    assert str(error) == "first\n  got:      1\nsecond"
    assert [problem.message for problem in error.problems] == ["first", "second"]
    with pytest.raises(ValueError, match="first"):
        raise error


@pytest.mark.parametrize(
    ("text", "rendered"),
    [
        ("gain\x1b[31m", "gain\\x1b[31m"),
        ("a\nb: fine", "a\\nb: fine"),
        ("\u202eniag", "\\u202eniag"),
        ("\ud800", "\\ud800"),
        ("Ω and µ", "Ω and µ"),
    ],
)
def test_nothing_from_a_file_can_steer_the_terminal_or_forge_a_line(text: str, rendered: str) -> None:
    assert str(Problem(message="unknown", key=text, got=text)) == f"{rendered}: unknown\n  got:      {rendered}"


@pytest.mark.parametrize(
    ("word", "found"),
    [
        ("dampign", "damping"),
        ("Stiffness", "stiffness"),
        ("proof_mass", "mass"),
        ("mas", "mass"),
        ("", ""),
        ("x" * 1000, ""),
    ],
)
def test_nearest_name(word: str, found: str) -> None:
    assert nearest(word, ["mass", "damping", "stiffness"]) == found


@pytest.mark.parametrize(
    ("word", "names", "hint"),
    [
        ("voltag", ["voltage", "code"], "did you mean voltage?"),
        ("gian", ["gain", "unit"], "did you mean gain?"),
        ("x", ["voltage"], "inputs: voltage."),
        ("x", ["b", "a"], "inputs: b, a."),
        ("x", {"b", "a"}, "inputs: a, b."),
        ("x", [], "inputs: none."),
        ("x", FEW, f"inputs: {', '.join(FEW[:12])}, and 2 more."),
        ("input_1", MANY, f"inputs: {', '.join(MANY[:12])}, and 2988 more."),
    ],
)
def test_the_nearest_name_or_the_valid_ones(word: str, names: Collection[str], hint: str) -> None:
    assert did_you_mean(word, names, "inputs") == hint


@pytest.mark.parametrize(
    ("beside", "hint"),
    [(("rate",), "did you mean name?"), (("name",), "did you mean rate?"), (("name", "rate"), "did you mean rate?")],
)
def test_what_already_stands_there_is_not_what_was_meant(beside: Collection[str], hint: str) -> None:
    assert did_you_mean("nate", ["name", "rate"], "keys", beside) == hint


class Awkward:
    def __repr__(self) -> str:
        raise RuntimeError("no")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.5, "1.5"),
        ("a\nb", "'a\\nb'"),
        ("25 µ", "'25 µ'"),
        ("nV/√Hz·m²", "'nV/√Hz·m²'"),
        ("größe аdc", r"'gr\xf6\xdfe \u0430dc'"),  # letters that look like others are escaped
        ("\x1b[31m\u202e", "'\\x1b[31m\\u202e'"),  # what could move a cursor or turn a line round is escaped
        (10**29, "1" + "0" * 29),
        (-(10**30), "an integer of over 30 digits"),
        (10**4000, "an integer of over 30 digits"),
        ([10**5000], "a list that cannot be shown"),
        (Awkward(), "a Awkward that cannot be shown"),
        ("x" * 100, "'" + "x" * 76 + "..."),
    ],
)
def test_values_are_shown_on_one_short_line(value: object, text: str) -> None:
    assert shown(value) == text


def slips(word: str) -> set[str]:
    """Words in which a letter was dropped, added or replaced, or two neighbours swapped, by their definition."""
    parts = [(word[:i], word[i:]) for i in range(len(word) + 1)]
    found = {a + b[1:] for a, b in parts if b} | {a + x + b for a, b in parts for x in "xyz"}
    found |= {a + x + b[1:] for a, b in parts if b for x in "xyz"}
    return (found | {a + b[1] + b[0] + b[2:] for a, b in parts if len(b) > 1}) - {word}


def test_one_slip_is_one_wherever_it_is_and_two_are_not() -> None:
    words = ["yx", "xyz", "zxyx", "xxyzz"]
    for word in words:
        others = {twice for once in slips(word) for twice in slips(once)} | slips(word)
        for other in sorted(others - {word}):
            expected = other in slips(word) and min(len(word), len(other)) > 1
            assert _one_slip(word, other) == _one_slip(other, word) == expected, (word, other)


def test_the_key_is_the_path_unless_it_is_said() -> None:
    path = ("blocks", "adc", "bits")
    assert Problem(message="too many", path=path).key == "blocks.adc.bits"
    assert Problem(message="too many", key="adc.code", path=path).key == "adc.code"
    assert Problem(message="too many").key == ""
    assert Problem(message="too many", path=path).error.problems == (Problem(message="too many", path=path),)


def test_what_is_refused_says_under_which_key() -> None:
    with pytest.raises(Refusal) as raised, under("band", [5, 1], "two frequencies"):
        raise Refusal("not ascending", "write [1, 5]")
    error = raised.value
    assert (str(error), error.key, error.got, error.expected) == ("not ascending", "band", "[5, 1]", "two frequencies")
    assert error.hint == "write [1, 5]"


def test_problems_are_collected_and_other_errors_are_not() -> None:
    problems: list[Problem] = []
    with collecting(problems, "5 kg", ("blocks", "mass")):
        raise Refusal("not a length", "write 5 m")
    with collecting(problems):
        raise ModelError([Problem(message="first"), Problem(message="second")])
    assert [str(problem).splitlines()[0] for problem in problems] == ["blocks.mass: not a length", "first", "second"]
    assert (problems[0].got, problems[0].hint) == ("'5 kg'", "write 5 m")
    with pytest.raises(ZeroDivisionError), collecting(problems):
        raise ZeroDivisionError
