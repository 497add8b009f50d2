"""The columns that say which point of a study a row of its tables is of."""

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study
from proofmass.runner.studies.shown.influences import place_of, point_columns
from proofmass.runner.studies.shown.points import parts
from proofmass.runner.studies.whole.study import run_study

GRAPH = """\
name = "a point"
rate = "1 kHz"
samples = 1
wires = ["offset.output -> both.first", "point.output -> both.second"]
[measures]
both = { signal = "both.output", statistic = "last" }
[blocks]
offset = { kind = "Constant", value = 0 }
point = { kind = "Constant", value = 0 }
both = { kind = "Sum" }
"""


def test_each_part_of_a_sweep_names_its_value() -> None:
    study = Study(
        read_graph_text(GRAPH), runs=2, spread={"offset.value": {"normal": 1}}, sweep={"point.value": [3.0, 5.0]}
    )
    by_point = list(parts(run_study(study, engine="python")).values())
    assert [point_columns(part) for part in by_point] == [{"point.value": 3.0}, {"point.value": 5.0}]
    assert place_of(by_point[1], "both", 0) == {"point.value": 5.0, "measure": "both", "epoch": 0, "age_s": 0.0}
