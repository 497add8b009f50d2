"""Calibrations along the epochs: registers outlive a run, against closed forms; replay, resuming, both engines."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.shown.plot import plot_study
from proofmass.runner.studies.shown.points import by_point, parts
from proofmass.runner.studies.whole.study import replay, run_study
from tests.by_hand.study_texts import CALIBRATED

YEAR = 31557600.0


def read(folder: Path, text: str = CALIBRATED) -> Study:
    path = folder / "study.toml"
    path.write_text(text)
    return read_study(path)


@pytest.fixture
def study(tmp_path: Path) -> Study:
    return read(tmp_path)


def test_what_is_found_has_drifted_since_the_last_calibration(tmp_path: Path) -> None:
    """Without noise: gain now / gain at the last calibration, 1 / gain in the register; nothing else."""
    quiet = read(tmp_path, CALIBRATED.replace("1e-6 1/sqrt(Hz)", "0 1/sqrt(Hz)"))
    result = run_study(quiet, engine="python")
    assert not result.faults
    for run in range(12):
        gain = np.array([at["amplifier.gain"] for at in quiet.drawn(run)])
        last = {0: [0, 0, 0, 0, 0], 1: [0, 0, 0, 2, 2], 2: [0, 0, 1, 2, 3]}[run % 3]
        before = np.array([1.0, *gain[last[1:]]])  # the new sensor has no calibration yet: its register holds one
        assert result["found"][run] == pytest.approx(gain / before, rel=1e-15)
        assert result["register"][run] == pytest.approx(1.0 / gain, rel=1e-15)


@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_a_replay_runs_the_calibrations_before_it(study: Study, engine: EngineName) -> None:
    result = run_study(study, engine="python")
    sensors = SensorRuns(study, "python")
    for run, epoch in ((5, 4), (4, 3), (3, 4), (2, 0)):
        again = replay(study, run, epoch, engine)
        assert {name: m.value for name, m in again.measures.items()} == {
            n: result[n][run, epoch] for n in result.values
        }
        register = sensors.parameters(run, epoch).get("register.initial", 1.0)
        assert again.graph.blocks["register"].initial == register  # type: ignore[attr-defined]
    quiet = Study(study.graph, epochs={"ages": [0]})
    assert SensorRuns(quiet, "python").parameters(0, 0) == {}


@pytest.mark.exhaustive
def test_order_engine_and_interruption_change_no_bit(study: Study, tmp_path: Path) -> None:
    python = run_study(study, engine="python")
    assert run_study(study, engine="compiled").digest == python.digest
    for lanes, threads in ((4, 1), (4, 3), (0, 2)):
        assert run_study(study, engine="compiled", lanes=lanes, threads=threads).digest == python.digest
    sensors = SensorRuns(study, "compiled")
    for number in (11, 0, 7):
        assert [run.values for run in sensors.run(number)] == list(
            zip(python["found"][number], python["register"][number], strict=True)
        )
    run_study(study, runs=1, engine="python", folder=tmp_path / "out")
    assert run_study(study, engine="python", folder=tmp_path / "out").digest == python.digest


def test_a_failed_calibration_leaves_the_registers_as_they_are(study: Study) -> None:
    sensors = SensorRuns(study, "python")
    whole = sensors.run(2)
    once = sensors._alone

    def fails_in_epoch_two(number: int, epoch: int, values: dict[str, float]) -> object:
        run = once(number, epoch, values)
        return run._replace(values=None, fault="lost") if epoch == 2 else run

    sensors._alone = fails_in_epoch_two  # type: ignore[method-assign,assignment]
    runs = sensors.run(2)
    assert runs[:2] == whole[:2]
    register = dict(zip(study.graph.measures, whole[1].values or (), strict=True))["register"]
    assert runs[3] == once(2, 3, study.drawn(2)[3] | {"register.initial": register})


def test_results_are_told_apart_by_their_interval(study: Study) -> None:
    result = run_study(study, engine="python")
    assert [result.study.recalibrated_every(point) for point in range(3)] == [float("inf"), 2.0 * YEAR, YEAR]
    for place, part in enumerate(by_point(result)):
        assert part.numbers.tolist() == [place, place + 3, place + 6, place + 9]
        assert part["found"].tolist() == result["found"][place::3].tolist()
    data = result.to_xarray()
    assert data["recalibration"].values.tolist() == [float("inf"), 2.0 * YEAR, YEAR] * 4
    labels = [text.get_text() for text in plot_study(result).legends[0].get_texts()]
    assert labels == ["never recalibrated", "recalibrated every 2 years", "recalibrated every year"]
    alone = replace(study.recalibration, every=(YEAR,))
    assert list(parts(replace(result, study=_with(study, alone)))) == ["recalibrated every year"]


def _with(study: Study, recalibration: object) -> Study:
    made = study.changed(runs=study.runs, seed=study.seed)
    object.__setattr__(made, "recalibration", recalibration)
    return made


NOTHING = """\
name = "a calibration that finds nothing"
rate = "1 kHz"
samples = 1
wires = ["drifting.output -> product.first", "register.output -> product.second"]
[measures]
y = { signal = "product.output", statistic = "last" }
new = "= sqrt(y)"
[blocks]
drifting = { kind = "Constant", value = 1 }
register = { kind = "Constant", value = 1 }
other = { kind = "Constant", value = 1 }
product = { kind = "Product" }
[study]
epochs = { ages = ["0 h", "1 year", "2 year", "3 year", "4 year"] }
drift = { "drifting.value" = { ramp = "-0.7 1/year" } }
changes = { since = { measure = "y", since = "calibration" } }
[study.recalibration]
every = "1 year"
carried = { "register.value" = "new", "other.value" = "y" }
"""


@pytest.mark.defect("S212", before="a calibration without a value made all later ones fail", after="nothing is stored")
@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_a_calibration_without_a_value_leaves_all_parameters(engine: EngineName, tmp_path: Path) -> None:
    study = read(tmp_path, NOTHING)
    result = run_study(study, runs=1, engine=engine)
    register, expected, stored = 1.0, [], 1.0
    for age in range(5):
        y = (1.0 - 0.7 * age) * register
        expected.append(y)
        if y >= 0.0:
            register, stored = np.sqrt(y), y
    assert result["y"][0] == pytest.approx(expected)
    assert np.isnan(result["new"][0, 2:]).all()
    assert np.isfinite(result["since"][0, 1:]).all()
    left = SensorRuns(study, "python").parameters(0, 4)
    assert (left["register.value"], left["other.value"]) == pytest.approx((register, stored))
