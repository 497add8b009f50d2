"""A study as text: it reads back to the same study, wherever that came from."""

import hashlib
import random
from pathlib import Path

import pytest

from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.graphs.studies.study_writer import files_beside, write_study
from tests.by_hand.study_texts import CALIBRATED, RICH, STUDY


@pytest.mark.parametrize("text", [STUDY, RICH, CALIBRATED], ids=["plain", "rich", "calibrated"])
def test_it_reads_back_to_the_same_study(text: str, tmp_path: Path) -> None:
    path, again = tmp_path / "study.toml", tmp_path / "elsewhere" / "again.toml"
    path.write_text(text)
    (tmp_path / "lot.csv").write_text("offset [mV]\n1001\n999.5\n1000\n")
    again.parent.mkdir()
    study = read_study(path)
    again.write_text(write_study(study))
    assert read_study(again) == study
    assert read_study(again).text() == study.text()
    assert read_study(again).drawn(3) == study.drawn(3)


@pytest.mark.parametrize(
    "law",
    [
        'ramp = "0 ppm/year", ramp_spread = "5 ppm/year"',
        'ramp = "0 ppm/year"',
        'random_walk = "0 ppm/sqrt(year)"',
        'logarithmic = 0, onset = "2 h", logarithmic_spread = "20 ppm"',
        'arrhenius = "0 ppm/year", temperature = "350 K"',
        'arrhenius = "0 ppm/year", mission = "car"',
        'cycles = 0, mission = "car"',
        'cycles = 0, cycles_spread = "1 ppm", cycle_range = "50 K", mission = "car"',
    ],
)
@pytest.mark.defect("C885", before="report refused the folder of a drift of 0 +- 5 ppm/year", after="it reads back")
def test_a_drift_of_zero_reads_back(law: str, tmp_path: Path) -> None:
    car = '[study.missions]\ncar = { phases = [{ temperature = "300 K", for = "1 h" }] }\n'
    at = STUDY.index("[study.drift]")
    head, _, tail = STUDY[at:].partition("}\n")
    drift = head[: head.index("{")] + f"{{ {law}, relative = true }}\n"
    (tmp_path / "study.toml").write_text(STUDY[:at] + drift + tail + (car if "mission" in law else ""))
    study = read_study(tmp_path / "study.toml")
    (tmp_path / "again.toml").write_text(write_study(study))
    assert read_study(tmp_path / "again.toml").drawn(3) == study.drawn(3)


def test_a_study_made_in_python(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    graph = read_study(tmp_path / "study.toml").graph
    made = Study(graph, runs=3, spread={"noise.density": {"lognormal": 0.1}}, epochs={"ages": ["1 h"]})
    (tmp_path / "made.toml").write_text(write_study(made))
    assert read_study(tmp_path / "made.toml") == made


@pytest.mark.parametrize("length", [1_001, pytest.param(100_000, marks=pytest.mark.exhaustive)])
def test_a_long_list_of_values_lies_beside_the_text(length: int, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    graph, dice = read_study(tmp_path / "study.toml").graph, random.Random(5)
    values = [dice.gauss(5.0, 1e-3) for _ in range(length)]
    made = Study(graph, spread={"adc.reference": {"values": values}, "source.value": {"values": [1.0, 2.0]}})
    ((name, content),) = files_beside(made).items()
    assert name == f"{hashlib.sha256(content).hexdigest()}.csv"
    (tmp_path / name).write_bytes(content)
    text = write_study(made)
    assert len(text) < 3000
    (tmp_path / "made.toml").write_text(text)
    again = read_study(tmp_path / "made.toml")
    assert again.spread["adc.reference"].values == tuple(sorted(values))
    assert again.spread["source.value"].values == (1.0, 2.0)
    assert len(made.text()) < 1000
    other = Study(graph, spread={"adc.reference": {"values": [*values[:-1], 5.0]}})
    assert other.text().splitlines()[-2] != made.text().splitlines()[-2]
