"""Ages at regular intervals, which of them calibrate, and mistakes in both tables."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Constant
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.epochs import NEVER, Recalibration
from proofmass.graphs.studies.study_reader import read_study
from tests.by_hand.graph_texts import changed, line_of
from tests.by_hand.study_texts import CALIBRATED

LEVEL = {"level": {"signal": "level.output", "statistic": "last"}}

MONTH, YEAR = 2629800.0, 31557600.0


def study(tmp_path: Path, text: str = CALIBRATED) -> Study:
    path = tmp_path / "study.toml"
    path.write_text(text)
    return read_study(path)


def test_ages_at_regular_intervals(tmp_path: Path) -> None:
    assert study(tmp_path).epochs == tuple(number * YEAR for number in range(5))
    monthly = changed(CALIBRATED, 'every = "1 year"\nuntil = "4 year"', 'every = "1 month"\nuntil = "1 year"')
    assert study(tmp_path, monthly).epochs == tuple(number * MONTH for number in range(13))


@given(st.lists(st.floats(0.0, 1e9), min_size=1, max_size=30, unique=True).map(sorted), st.floats(1.0, 1e9))
def test_a_calibration_is_due_when_its_interval_is_over(ages: list[float], interval: float) -> None:
    every = Recalibration(carried={"a.b": "c"})
    found = every.at(tuple(ages), interval)
    assert found[0]
    last = 0
    for epoch in range(1, len(ages)):
        assert found[epoch] == (ages[epoch] - ages[last] >= interval * (1.0 - 1e-9))
        last = epoch if found[epoch] else last
    assert every.at(tuple(ages), float("inf")) == (True,) + (False,) * (len(ages) - 1)
    assert not any(Recalibration().at(tuple(ages), interval))


def test_rounded_ages_are_not_late() -> None:
    """A year is twelve months of 30.4375 days, summed with rounding or not."""
    monthly = tuple(0.1 * number for number in range(121))
    assert Recalibration(carried={"a.b": "c"}).at(monthly, 1.2) == tuple(n % 12 == 0 for n in range(121))


def test_every_interval_is_a_point_with_the_same_sensors(tmp_path: Path) -> None:
    made = study(tmp_path)
    assert made.recalibration.every == (float("inf"), 2.0 * YEAR, YEAR)
    assert made.points == 3
    assert [made.recalibrated_every(run) for run in range(4)] == [float("inf"), 2.0 * YEAR, YEAR, float("inf")]
    assert made.drawn(3) == made.drawn(4) == made.drawn(5) != made.drawn(6)
    assert made.calibrated(4) == (True, False, True, False, True)
    text = made.text()
    assert "recalibration.every = [inf, 63115200.0, 31557600.0]" in text
    assert "recalibration.carried.register.initial = register" in text
    assert "recalibration" not in study(tmp_path, CALIBRATED.partition("[study.recalibration]")[0]).text()


@pytest.mark.parametrize(
    ("old", "new", "said", "place"),
    [
        ('until = "4 year"', 'until = "4 yaer"', "did you mean year?", "until"),
        ('until = "4 year"', 'untill = "4 year"', "must hold a list of ages", "[study.epochs]"),
        ('every = "1 year"', 'every = "0 s"', "epochs in all", "every"),
        ('every = "1 year"', 'every = "1 s"', "epochs in all", "every"),
        (f'["{NEVER}", "2 year", "1 year"]', '"nevre"', "recalibration.every", "nevre"),
        (f'["{NEVER}", "2 year", "1 year"]', "[]", "must say how often", "every = []"),
        (f'["{NEVER}", "2 year", "1 year"]', '["1 year", "12 month"]', "must differ", '"12 month"'),
        ('"register.initial" = "register"', '"register.intial" = "register"', "did you mean initial?", "intial"),
        ('"register.initial" = "register"', '"register.initial" = "regster"', "did you mean register?", "regster"),
        (
            '"register.initial" = "register"',
            '"amplifier.gain" = "register"',
            "nothing else can move it",
            "[study.drift]",
        ),
        (
            '"register.initial" = "register"',
            '"width.value" = "register"',
            "another unit than the parameter",
            '"width.value"',
        ),
        ('{ "register.initial" = "register" }', "{ }", "leaves nothing", "[study.recalibration]"),
        ("carried = {", "caried = {", "did you mean carried?", "caried"),
    ],
)
def test_mistakes_are_told_with_their_line(tmp_path: Path, old: str, new: str, said: str, place: str) -> None:
    text = CALIBRATED.replace(old, new, 1)
    assert text != CALIBRATED
    with pytest.raises(ModelError) as caught:
        study(tmp_path, text)
    assert said in str(caught.value)
    lines = [problem.line for problem in caught.value.problems]
    assert any(abs(line - line_of(text, place)) <= 1 for line in lines), (lines, line_of(text, place))


def test_a_parameter_that_is_swept_drifts_from_each_of_its_values() -> None:
    """10 % a year for two years are 20 %."""
    graph = Graph(name="a level", rate="1 kHz", blocks={"level": Constant()}, measures=LEVEL)
    drift, ages = {"level.value": {"ramp": "10 %/year", "relative": True}}, {"ages": ["0 h", "2 year"]}
    study = Study(graph, runs=2, sweep={"level.value": [1.0, 2.0]}, drift=drift, epochs=ages)
    found = [[at["level.value"] for at in study.drawn(run)] for run in range(study.points)]
    assert found == [pytest.approx([1.0, 1.2]), pytest.approx([2.0, 2.4])]
