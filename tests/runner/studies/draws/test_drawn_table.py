"""The table of what was drawn in every format, against what the runs themselves measured."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
import xarray

from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.draws.drawn_table import DrawnTable
from proofmass.runner.studies.kept.folder import kept_result
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.whole.study import replay, run_study
from tests.by_hand.amounts import chosen
from tests.by_hand.random_studies import random_study

LIBRARY = [name for name, path in library_files().items() if "[study" in path.read_text()]
SOME = ["calibration_interval_study.toml", "closed_loop_gyroscope.toml", "self_calibration_population.toml"]
Table = dict[str, list[list[float]]]  # by column without its unit, a row for each run


def in_every_format(result: StudyResult, folder: Path) -> dict[str, Table]:
    """The columns of a study, read back by other readers."""
    shape = len(result.numbers), len(result.study.epochs)
    with save_study_csv(result, folder / "study.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    frame = result.to_pandas()
    parquet = pyarrow.parquet.read_table(save_study_parquet(result, folder / "study.parquet"))
    with xarray.open_dataset(save_study_netcdf(result, folder / "study.nc")) as data:
        sets = {"netCDF": data.load(), "xarray": result.to_xarray()}
    found: dict[str, dict[str, Any]] = {
        "CSV": {n.partition(" [")[0]: c for n, c in zip(head, zip(*rows, strict=True), strict=True) if n != "fault"},
        "Parquet": {name: parquet[name].to_pylist() for name in parquet.column_names if name != "fault"},
        "pandas": {name: frame[name].tolist() for name in frame.columns},
    }
    for form, labelled in sets.items():
        whole = {str(n): labelled[n].broadcast_like(labelled[next(iter(result.values))]) for n in labelled.variables}
        found[form] = {name: array.transpose("run", "epoch").values for name, array in whole.items()}
    return {
        form: {n: np.array(c, dtype=float).reshape(shape).tolist() for n, c in columns.items()}
        for form, columns in found.items()
    }


def check(result: StudyResult, shown: dict[str, str], folder: Path) -> None:
    study = result.study
    varied = {*study.spread, *study.sweep, *study.drift}
    assert varied
    for form, columns in in_every_format(result, folder).items():
        for name in varied:
            assert columns[name] == result[shown[name]].tolist(), (form, name)
        assert columns["age"] == [list(study.epochs)] * len(result.numbers), form
        if study.recalibration.carried:
            every = [[study.recalibrated_every(run)] * len(study.epochs) for run in result.numbers.tolist()]
            assert columns["recalibration"] == every, form


@pytest.mark.exhaustive(but=1)
@pytest.mark.defect("S200", before="columns of parameters held one another's numbers", after="each holds its own")
@pytest.mark.defect("S201", before="a follower kept its first age in netCDF and pandas", after="one number an age")
@pytest.mark.parametrize("seed", chosen(range(8), range(8, 200)))
def test_every_format_holds_what_the_run_measured(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if seed % 2:
        monkeypatch.setattr("proofmass.runner.studies.draws.drawn_table._ONE_BY_ONE", 0)
    study, shown = random_study(seed)
    check(run_study(study, engine="python", folder=tmp_path), shown, tmp_path)
    check(kept_result(tmp_path), shown, tmp_path)


def held_by(graph: Graph, path: str) -> float:
    """The number of a parameter, or of a value of the graph or of a part."""
    block, name = split(path)
    blocks = flatten(graph).blocks
    if block in blocks:
        return float(getattr(blocks[block], name))
    for part in filter(None, block.split(".")):
        graph = graph.subgraphs[part]
    return graph.values[name].number


@pytest.mark.exhaustive("calibration_interval_study.toml", "closed_loop_gyroscope.toml")
@pytest.mark.parametrize("name", chosen(SOME, sorted(set(LIBRARY) - set(SOME))))
def test_every_study_of_the_library(name: str, tmp_path: Path) -> None:
    study = read_study(f"library:{name}")
    numbers = np.arange(2 * study.points)[-2:]
    measures = SensorRuns(study, "python").measures
    values = dict.fromkeys((measure.name for measure in measures), np.zeros((2, len(study.epochs))))
    result = StudyResult(study, measures, numbers, values, {}, 2, 0.0, "")
    tables = in_every_format(result, tmp_path)
    epoch = len(study.epochs) - 1
    for place, run in enumerate(numbers.tolist()):
        graph = replay(study, run, epoch).graph
        for column in DrawnTable(study, numbers).parameters:
            had = held_by(graph, column.parameter)
            for form, columns in tables.items():
                assert columns[column.name][place][epoch] == had, (form, column.name)


@pytest.mark.exhaustive
@pytest.mark.defect("S202", before="a common value had share 0 beside its follower's 1", after="half each")
def test_a_common_value_keeps_its_share() -> None:
    text = """\
name = "one beam"
rate = "1 kHz"
samples = 1
values = { thickness = 2.0 }
measures = { stiffness = { signal = "beam.output", statistic = "last" } }
blocks = { beam = { kind = "Constant", value = "= 3 * thickness" } }
"""
    spread = {name: {"normal": "3 %", "relative": True} for name in ("thickness", "beam.value")}
    result = run_study(Study(read_graph_text(text), runs=4000, seed=2, spread=spread), engine="python")
    rows = {row["factor"]: row for row in StudyInfluences(result).rows()}
    assert rows["thickness"]["slope"] == pytest.approx(3.0, rel=2e-3)
    assert rows["beam.value"]["slope"] == pytest.approx(1.0, rel=2e-3)
    for row in rows.values():
        assert row["share"] == pytest.approx(0.5, abs=0.02)
        assert row["effect"] == pytest.approx(6.0 * 0.03, rel=0.03)


@pytest.mark.defect("S203", before="a value named epoch took the place of the epochs", after="a column of its own")
def test_no_two_columns_have_one_name(tmp_path: Path) -> None:
    names = ("run", "epoch", "age", "fault", "bias")
    text = f"""\
name = "names"
rate = "1 kHz"
samples = 1
values = {{ {", ".join(f"{name} = {place}" for place, name in enumerate(names, 1))} }}
measures = {{ bias = {{ signal = "run.output", statistic = "last" }} }}
blocks = {{ {", ".join(f'{name} = {{ kind = "Constant", value = "= {name}" }}' for name in names)} }}
"""
    spread = {name: {"uniform": 0.1} for name in names}
    study = Study(read_graph_text(text), runs=3, spread=spread)
    result = run_study(study, engine="python")
    for form, columns in in_every_format(result, tmp_path).items():
        for name in names:
            drawn = [[at[name] for at in study.drawn(run)] for run in range(3)]
            assert columns[f"parameter.{name}"] == drawn, (form, name)
        assert columns["bias"] == result["bias"].tolist()
