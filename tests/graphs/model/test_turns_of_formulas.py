"""Units of formulas that are one quantity, or the name of one."""

import pytest

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.study_reader import read_study_text
from tests.by_hand.graph_texts import problems_of

TURNING = """\
name = "turning"
rate = "{rate}"
samples = 3
measures.m = {{ signal = "s.output", statistic = "tone_amplitude", frequency = "{tone}" }}
[values]
w = "100 rad/s"
f = "25 Hz"
again = "= w"
q_factor = 0.5
[blocks]
s = {{ kind = "Sine", frequency = "{frequency}" }}
spin = {{ kind = "Constant", value = "{spin}", unit = "rad/s" }}
"""
GOOD = {"rate": "1 kHz", "tone": "100 Hz", "frequency": "1 Hz", "spin": "1 rad/s"}


def refused(key: str, formula: str) -> list[Problem]:
    """Problems of a text with a formula, but notes."""
    return [problem for problem in problems_of(TURNING.format(**{**GOOD, key: formula})) if not problem.note]


@pytest.mark.parametrize(
    ("key", "formula", "cure"),
    [
        ("frequency", "= 100 rad/s", 'write "15.91549431 Hz"'),
        ("frequency", "= w", 'write "= w / (2 * pi)"'),
        ("frequency", "= again", 'write "= again / (2 * pi)"'),
        ("rate", "= w", 'write "= w / (2 * pi)"'),
        ("tone", "= w", 'write "= w / (2 * pi)"'),
        ("spin", "= f", 'write "= 2 * pi * f"'),
        ("spin", "= 25 Hz", 'write "157.0796327 rad/s"'),
    ],
)
@pytest.mark.defect("S962", before='"= 100 rad/s" was 100 Hz', after="refused, with what to write: 15.9 Hz")
def test_a_quantity_alone_is_not_turned_by_its_formula(key: str, formula: str, cure: str) -> None:
    (problem,) = refused(key, formula)
    assert problem.hint == cure
    told = cure.split('"')[1]
    assert refused(key, told) == []


@pytest.mark.parametrize(
    ("key", "formula", "cure"),
    [
        ("frequency", "= w * 1", "(w * 1) / (2 * pi)"),
        ("frequency", "= sqrt(w^2 + again^2)", "(sqrt(w^2 + again^2)) / (2 * pi)"),
        ("frequency", "= 2 s * w / 1 s", "(2 s * w / 1 s) / (2 * pi)"),
        ("rate", "= 16 * again", "(16 * again) / (2 * pi)"),
        ("tone", "= max(w, 1 / s)", "(max(w, 1 / s)) / (2 * pi)"),
        ("spin", "= f / 4", "2 * pi * (f / 4)"),
        ("spin", "= 25 Hz/V * 2 V", "2 * pi * (25 Hz/V * 2 V)"),
    ],
)
@pytest.mark.defect("S996", before='"= w * 1" of 100 rad/s was 100 Hz', after="refused, with what to write")
def test_whole_numbers_and_sums_do_not_turn(key: str, formula: str, cure: str) -> None:
    (problem,) = refused(key, formula)
    assert problem.hint == f'write "= {cure}"'
    assert refused(key, f"= {cure}") == []


@pytest.mark.parametrize("formula", ["= w + 1 Hz", "= hypot(f, w)", "= 1 rad/s - 2 * f"])
@pytest.mark.defect("S996", before="100 rad/s and 1 Hz made 101 Hz", after="refused: one turn is 2 pi rad")
def test_a_sum_of_angle_and_turns_is_refused(formula: str) -> None:
    (problem,) = refused("frequency", formula)
    assert "a sum takes angle and turns" in problem.message


@pytest.mark.parametrize(
    ("key", "formula"),
    [
        ("frequency", "= w / 6.28"),
        ("frequency", "= w / (360 deg)"),
        ("frequency", "= f^2 / f + f / q_factor"),
        ("frequency", "= 1 / 5 ms"),
        ("frequency", "= f * (1 + 85 ppm)"),
        ("frequency", "= w * f / w"),
        ("spin", "= f * 360 deg"),
        ("spin", "= 2 * pi * f + w"),
        ("spin", "= 2 * w + 3 deg/s"),
        ("spin", "= 2 * pi * f"),
        ("frequency", "= f"),
        ("spin", "= w"),
        ("spin", "= 90 deg/s"),
    ],
)
def test_formulas_that_may_turn_are_taken(key: str, formula: str) -> None:
    assert refused(key, formula) == []


WITHIN = """\
name = "within"
rate = "1 kHz"
samples = 3
measures.top = {{ signal = "part.s.output", statistic = "max" }}
[values]
w = "100 rad/s"
[blocks.part]
values = {{ f = "1 Hz" }}
blocks.s = {{ kind = "Sine", frequency = "= f" }}
[formulas]
"part.f" = "{formula}"
[study]
runs = 2
spread = {{ "part.f" = {{ normal = "{width}" }} }}
"""


@pytest.mark.defect("S997", before="100 rad/s went into a part as 100 1/s, and was 100 Hz there", after="refused")
def test_a_value_of_a_part_is_not_turned() -> None:
    (problem,) = problems_of(WITHIN.format(formula="= w", width="1 Hz"))
    assert problem.hint == 'write "= w / (2 * pi)"'
    graph = read_graph_text(WITHIN.format(formula="= w / (2 * pi)", width="1 Hz"))
    assert graph.subgraphs["part"].blocks["s"].frequency == pytest.approx(100.0 / 6.283185307179586)  # type: ignore[attr-defined]
    with pytest.raises(ModelError, match="rad/s is angle, not turns a second"):
        graph.with_parameters({"part.f": "100 rad/s"})


@pytest.mark.defect("S997", before="a width of 1 rad/s was 1 Hz", after="refused, with the width in Hz")
def test_the_spread_of_a_value_is_not_turned() -> None:
    with pytest.raises(ModelError, match=r'write "0.1591549431 Hz"'):
        read_study_text(WITHIN.format(formula="= w / (2 * pi)", width="1 rad/s"))


SHOWN = """\
rate = "1 kHz"
samples = 3
wires = ["spin.output -> gyroscope.input", "beat.output -> counter.input"]
probes = ["gyroscope.output"]
[measures]
rate = {{ signal = "gyroscope.output", statistic = "last", unit = "{rate}" }}
tone = {{ signal = "counter.output", statistic = "last", unit = "{tone}" }}
made = {{ formula = "{formula}", unit = "{made}" }}
[blocks]
spin = {{ kind = "Constant", value = "1 deg/s", unit = "rad/s" }}
beat = {{ kind = "Constant", value = "1 Hz", unit = "Hz" }}
gyroscope = {{ kind = "UnitDelay", unit = "rad/s" }}
counter = {{ kind = "UnitDelay", unit = "Hz" }}
"""
SHOWN_RIGHT = {"rate": "deg/h", "tone": "kHz", "formula": "= rate - rate / 2", "made": "deg/s"}


@pytest.mark.parametrize(("key", "unit"), [("rate", "kHz"), ("tone", "deg/s"), ("tone", "mrad/s")])
@pytest.mark.defect("S1001", before="1 Hz shown as 57.3 deg/s, which is 360", after="refused")
def test_what_is_measured_is_not_turned_where_it_is_shown(key: str, unit: str) -> None:
    assert problems_of(SHOWN.format(**SHOWN_RIGHT)) == []
    (problem,) = problems_of(SHOWN.format(**{**SHOWN_RIGHT, key: unit}))
    assert f"cannot be shown in {unit}" in problem.message


@pytest.mark.parametrize(
    ("formula", "made", "words"),
    [
        ("= 2 * tone", "deg/s", "cannot be shown in deg/s"),
        ("= rate * 2", "Hz", "cannot be shown in Hz"),
        ("= tone + rate", "Hz", "a sum takes angle and turns"),
    ],
)
@pytest.mark.defect("S1002", before="1 deg/s and 1 Hz made 1.017 Hz", after="refused")
def test_a_measure_of_measures_is_not_turned(formula: str, made: str, words: str) -> None:
    (problem,) = problems_of(SHOWN.format(**{**SHOWN_RIGHT, "formula": formula, "made": made}))
    assert words in problem.message
    assert problems_of(SHOWN.format(**{**SHOWN_RIGHT, "formula": "= rate / (2 * pi) + tone", "made": "Hz"})) == []
