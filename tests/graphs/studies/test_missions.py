"""Mission profiles: rainflow counting against the standard's example, ageing against integrals by SciPy."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.constants import Boltzmann, electron_volt
from scipy.integrate import quad

from proofmass.blocks.declaration.problem import ModelError, Refusal
from proofmass.graphs.studies.ageing import read_drift
from proofmass.graphs.studies.missions import cycles, read_mission
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.graphs.studies.study_writer import write_study
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import STUDY

DAY, YEAR = 86400.0, 31557600.0
PHASES = {"phases": [{"temperature": "253 K", "for": "8 h"}, {"temperature": "353 K", "for": "16 h"}]}
POINTS = {"points": [["0 h", "253 K"], ["8 h", "353 K"], ["10 h", "353 K"], ["24 h", "253 K"]]}
MISSION = """
[study.missions]
car = { phases = [{ temperature = "253 K", for = "8 h" }, { temperature = "353 K", for = "16 h" }] }
[study.drift]
"source.value" = { arrhenius = "1 ppm/year", cycles = "1 ppb", mission = "car", relative = true }
"""


def acceleration(kelvin: float) -> float:
    return math.exp(0.7 * electron_volt / Boltzmann * (1.0 / 298.15 - 1.0 / kelvin))


def aged(mission: dict[str, Any], **laws: Any) -> list[float]:
    table = {"relative": True, "mission": "m", "activation_energy": "0.7 eV", **laws}
    if "arrhenius" not in laws:
        table.pop("activation_energy")
    drift = read_drift(table, "V", {"m": read_mission(mission, ".")})
    return [value - 1.0 for value in drift.aged(1.0, [0.0, 0.3 * DAY, YEAR], 3, 0, 8)]


def test_rainflow_counting_of_the_standard() -> None:
    """The history of figure 6 of ASTM E1049, repeated: one cycle each of 3, 4, 7 and 9."""
    assert sorted(cycles([-2, 1, -3, 5, -1, 3, -4, 4, -2])) == [3, 4, 7, 9]
    assert cycles([253, 353, 353, 253]) == (100,)
    assert cycles([300, 300]) == ()


@pytest.mark.parametrize("shift", range(8))
def test_where_a_repeating_history_begins_makes_no_difference(shift: int) -> None:
    history = np.roll([-2, 1, -3, 5, -1, 3, -4, 4], shift).tolist()
    assert sorted(cycles([*history, history[0]])) == [3, 4, 7, 9]


def test_ageing_over_phases_is_the_mean_of_their_paces() -> None:
    new, short, year = aged(PHASES, arrhenius="1 ppm/year")
    pace = 1e-6 / YEAR
    assert new == 0.0
    assert short == pytest.approx(pace * 0.3 * DAY * acceleration(253.0), abs=1e-15)
    days = YEAR / DAY
    whole = math.floor(days) * DAY * (acceleration(253.0) / 3.0 + acceleration(353.0) * 2.0 / 3.0)
    assert year == pytest.approx(pace * (whole + 0.25 * DAY * acceleration(253.0)), rel=1e-7)


def test_ageing_along_lines_is_the_integral() -> None:
    *_, year = aged(POINTS, arrhenius="1 ppm/year")
    history = np.array([[0.0, 253.0], [8.0, 353.0], [10.0, 353.0], [24.0, 253.0]]) * [3600.0, 1.0]
    day = quad(lambda t: acceleration(float(np.interp(t, *history.T))), 0.0, DAY, points=[28800.0, 36000.0])[0]
    quarter = quad(lambda t: acceleration(float(np.interp(t, *history.T))), 0.0, 0.25 * DAY)[0]
    assert year == pytest.approx(1e-6 / YEAR * (365 * day + quarter), rel=1e-7)


def test_cycles_wear_by_the_power_of_their_range() -> None:
    *_, year = aged(PHASES, cycles="2 ppb", cycle_range="50 K", cycle_exponent=3)
    assert year == pytest.approx(2e-9 * 365.25 * 8.0, rel=1e-7)


def test_a_random_walk_adds_to_the_other_laws() -> None:
    """With deviates of one, each step is the root of its time."""
    laws = {"random_walk": "3 ppm/sqrt(year)", "ramp": "1 ppm/year", "cycles": "2 ppb", "cycle_range": "100 K"}
    mission = read_mission(PHASES, ".")
    drift = read_drift({"relative": True, "mission": "m", **laws}, "V", {"m": mission})
    found = drift.aged(2.0, [YEAR, 5.0 * YEAR], 3, 0, 8, lambda *_: 1.0)
    year = 2e-9 * 365.25  # what cycles do
    assert found[0] == pytest.approx(2.0 * (1.0 + 4e-6 + year), rel=1e-14)
    assert found[1] == pytest.approx(2.0 * (1.0 + 14e-6 + 5.0 * year), rel=1e-14)


def test_the_spread_of_cycles_is_between_sensors() -> None:
    table = {"cycles": "1 ppm", "cycles_spread": "0.1 ppm", "mission": "m", "relative": True}
    drift = read_drift(table, "V", {"m": read_mission(PHASES, ".")})
    paces = np.array([drift.aged(1.0, [DAY, 100.0 * DAY], 3, run, 8) for run in range(2000)]) - 1.0
    assert paces[:, 0] == pytest.approx(paces[:, 1] / 100.0, rel=1e-8)
    assert paces[:, 0].mean() == pytest.approx(1e-6, rel=0.01)
    assert paces[:, 0].std() == pytest.approx(0.1e-6, rel=0.06)


def test_a_history_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "chamber.csv").write_text("t [h],oven [K]\n2,253\n10,353\n12,353\n26,253\n")
    named = {"file": "chamber.csv", "time": "t", "temperature": "oven"}
    mission = read_mission(named, str(tmp_path))
    assert mission == read_mission(POINTS, ".")
    assert repr(mission) == "Mission(0.0: 253.0, 28800.0: 353.0, 36000.0: 353.0, 86400.0: 253.0)"


@pytest.mark.exhaustive
def test_a_study_of_a_mission_is_written_and_runs_alike_in_all_engines() -> None:
    study = read_study_text(STUDY.partition("[study.drift]")[0] + MISSION)
    assert read_study_text(write_study(study)).drift == study.drift
    python = run_study(study, engine="python")
    assert run_study(study, engine="compiled").digest == python.digest
    assert "Mission(0.0: 253.0" in study.text()


@pytest.mark.parametrize(
    ("mission", "said"),
    [
        ({}, "needs phases, points or a file"),
        ({"phases": []}, "must be a list of phases"),
        ({"phases": [{"temperature": "300 K"}]}, "needs temperature and for"),
        ({"points": [["1 h", "300 K"], ["2 h", "300 K"]]}, "is not a history"),
        ({"points": [["0 h", "300 K"], ["2 h", "0 K"]]}, "out of range"),
        ({"points": [["0 h", "300 K", 1]]}, "must be a list of times with temperatures"),
        ({"phases": [{"temperature": "300 K", "for": "soon"}]}, "a time"),
    ],
)
def test_wrong_missions_are_refused(mission: dict[str, Any], said: str) -> None:
    with pytest.raises(Refusal) as caught:
        read_mission(mission, ".")
    assert said in f"{caught.value} {caught.value.expected}"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('mission = "car"', 'mission = "cra"', "did you mean car?"),
        (', mission = "car"', "", "needs a mission"),
        ('mission = "car"', 'mission = "car", temperature = "300 K"', "the mission says the temperature"),
    ],
)
def test_wrong_uses_of_missions_are_refused(old: str, new: str, said: str) -> None:
    with pytest.raises(ModelError) as caught:
        read_study_text(STUDY.partition("[study.drift]")[0] + MISSION.replace(old, new))
    assert said in str(caught.value)
