"""Studies: what is drawn, order and independence of it, and mistakes said with line, key and nearest name."""

from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.keys import STUDY_INTEGERS
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.changes import Change
from proofmass.graphs.studies.study_reader import read_study, read_study_text
from proofmass.graphs.studies.study_writer import write_study
from proofmass.graphs.tuning.check_file import check_file
from tests.by_hand.graph_texts import STUDIES, changed, line_of
from tests.by_hand.study_texts import RICH, STUDY

YEAR = 31557600.0


def study(tmp_path: Path, text: str = STUDY) -> Study:
    path = tmp_path / "study.toml"
    path.write_text(text)
    return read_study(path)


def test_defaults_are_those_that_the_schema_tells() -> None:
    plain = read_study_text(STUDY.split("[study]\n")[0] + "[study]\n")
    assert {name: row.default for name, row in STUDY_INTEGERS.items()} == {"runs": plain.runs, "seed": plain.seed}


def test_a_file_of_its_own_a_table_and_python_give_the_same_study(tmp_path: Path) -> None:
    graph, table = STUDY.split("[study]\n")
    (tmp_path / "converter.toml").write_text(graph)
    alone = tmp_path / "alone.toml"
    alone.write_text('graph = "converter.toml"\n' + table.replace("study.", ""))
    made = Study(
        read_graph_text(graph),
        runs=6,
        seed=11,
        spread={
            "adc.reference": {"normal": 200e-6, "relative": True},
            "source.value": {"uniform": 1e-3},
        },
        sweep={"filter.corner_frequency": [100.0, 200]},
        epochs={"ages": [0, "1000 h", YEAR]},
        drift={
            "adc.reference": {
                "ramp": "20 ppm/year",
                "ramp_spread": "5 ppm/year",
                "random_walk": "9 ppm/sqrt(year)",
                "relative": True,
            }
        },
        limits={"bias": {"change": 1e-4}, "noise": {"at_most": 100}},
    )
    assert study(tmp_path) == read_study(alone) == made


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_the_studies_of_the_library_have_no_problems(path: Path) -> None:
    assert check_file(path).problems == []
    assert read_study(path).limits


def test_every_point_of_the_sweep_is_tried_with_the_same_sensors(tmp_path: Path) -> None:
    made = study(tmp_path)
    assert made.points == 2
    assert str(tmp_path) not in repr(made)  # where it comes from
    for run in range(0, 12, 2):
        low, high = made.drawn(run), made.drawn(run + 1)
        for first, second in zip(low, high, strict=True):
            assert first.pop("filter.corner_frequency") == 100.0
            assert second.pop("filter.corner_frequency") == 200.0
            assert first == second
    assert made.drawn(0)[0]["source.value"] != made.drawn(2)[0]["source.value"]
    assert len({made.drawn(4)[epoch]["source.value"] for epoch in range(3)}) == 1
    grid = Study(made.graph, sweep={"source.value": [1, 2], "adc.reference": [3, 4, 5]})
    points = [tuple(grid.point(run).values()) for run in range(7)]
    assert points == [(1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5), (1, 3)]


def test_a_study_about_other_values_is_the_one_that_sweeps_them_alone(tmp_path: Path) -> None:
    about = study(tmp_path).at({"filter.corner_frequency": 150.0})
    alone = study(tmp_path, STUDY.replace('["100 Hz", "200 Hz"]', '["150 Hz"]'))
    assert about.points == 1
    assert [about.drawn(run) for run in range(6)] == [alone.drawn(run) for run in range(6)]


def test_what_is_drawn_does_not_depend_on_other_parameters(tmp_path: Path) -> None:
    made, text = study(tmp_path), STUDY.replace('"source.value" = { uniform = "1 mV" }\n', "")
    fewer = study(tmp_path, text)
    for run in (7, 0, 3):
        assert fewer.drawn(run)[2]["adc.reference"] == made.drawn(run)[2]["adc.reference"]


def test_changes_of_measures_are_measures(tmp_path: Path) -> None:
    table = '[study.changes]\ndrift = { measure = "bias", since = "1000 h", relative = true }\n[study.limits]'
    made = study(tmp_path, STUDY.replace("[study.limits]", table + "\ndrift = { at_most = 1e-3 }"))
    assert made.changes["drift"] == Change("bias", 3.6e6, True)
    assert made.limits["drift"].at_most == 1e-3
    assert "changes.drift" in made.text()
    assert read_study_text(write_study(made)) == made


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('{ measure = "bais" }', "must name a measure"),
        ('{ measure = "bias", since = "calibration" }', "the study calibrates nothing"),
        ('{ measure = "bias", since = "9 year" }', "no epoch is so old"),
        ('{ measure = "bias", since = "soon" }', "an age"),
        ('{ measure = "bias", sicne = 0 }', "did you mean since?"),
        ('{ measure = "bias", relative = 1 }', "must be true or false"),
    ],
)
def test_a_wrong_change_is_refused(tmp_path: Path, entry: str, said: str) -> None:
    with pytest.raises(ModelError, match=r"changes\.drift") as caught:
        study(tmp_path, STUDY + f"\n[study.changes]\ndrift = {entry}\n")
    assert said in str(caught.value)


@pytest.mark.defect("S218", before="the change since the next age, 5 years", after="refused, with the ages beside it")
def test_a_change_since_an_age_between_two_is_refused(tmp_path: Path) -> None:
    table = '[study.changes]\ndrift = { measure = "bias", since = "13 month" }\n[study.epochs]'
    aged = STUDY.partition("ages =")[0].replace("[study.epochs]", table) + 'ages = ["0 h", "12 month", "5 year"]\n'
    with pytest.raises(ModelError, match=r"(?s)no epoch is at this age.*1 year or 5 years"):
        study(tmp_path, aged)
    assert study(tmp_path, aged.replace("13 month", "1 year")).changes["drift"].reference([0.0, 31557600.0]) == 1


def test_a_change_may_not_take_the_name_of_a_measure(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="there is a measure of that name"):
        study(tmp_path, STUDY + '\n[study.changes]\nbias = { measure = "noise" }\n')


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ("runs = 6", "rnus = 6", "rnus", "did you mean runs?"),
        ("runs = 6", "runs = 0", "runs", "an integer from 1"),
        ("seed = 11", "seed = -1", "seed", "an integer from 0"),
        ('"adc.reference" = { normal', '"adc.refrence" = { normal', 'spread."adc.refrence"', "did you mean reference?"),
        ('"adc.reference" = { normal', '"acd.reference" = { normal', 'spread."acd.reference"', "did you mean adc?"),
        ('"adc.reference" = { normal', '"adc.bits" = { normal', 'spread."adc.bits"', "not a number that may vary"),
        ('"adc.reference" = { normal', '"adc.voltage" = { normal', 'spread."adc.voltage"', "is a port"),
        ("{ normal", "{ nromal", 'spread."adc.reference".nromal', "did you mean normal?"),
        ('uniform = "1 mV"', 'uniform = "1 mA"', 'spread."source.value".uniform', "a number in V"),
        ('uniform = "1 mV"', "uniform = -1", 'spread."source.value".uniform', "at least 0"),
        ('uniform = "1 mV"', "relative = false", 'spread."source.value"', "needs one distribution"),
        ('["100 Hz", "200 Hz"]', "[]", 'sweep."filter.corner_frequency"', "list of values"),
        ('"1000 h", "1 year"', '"1 year", "1000 h"', "epochs.ages", "must ascend"),
        ('"1000 h"', '"1000 V"', "epochs.ages.1", "1000 V"),
        ("ramp = ", "rmap = ", 'drift."adc.reference".rmap', "did you mean ramp?"),
        (
            'ramp = "20 ppm/year", ramp_spread',
            "ramp_spread",
            'drift."adc.reference".ramp_spread',
            "no ramp to go with it",
        ),
        ('"20 ppm/year"', '"20 ppm"', 'drift."adc.reference".ramp', "a number in 1/s"),
        ("at_most = 100", "at_most = 100, at_least = 101", "limits.noise", "no sensor can keep it"),
        ('change = "100 ppm"', 'change = "-100 ppm"', "limits.bias.change", "at least 0"),
        ("noise = { at_most", "nosie = { at_most", "limits.nosie", "did you mean noise?"),
        ("at_most", "at_msot", "limits.noise.at_msot", "did you mean at_most?"),
    ],
)
def test_mistakes_are_said_with_line_key_and_nearest_name(
    old: str, new: str, key: str, said: str, tmp_path: Path
) -> None:
    text = changed(STUDY, old, new)
    with pytest.raises(ModelError) as caught:
        study(tmp_path, text)
    (problem,) = caught.value.problems
    assert (problem.file, problem.key) == (str(tmp_path / "study.toml"), key)
    assert problem.line == line_of(text, new)
    assert said in str(problem)


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ('"latin_hypercube"', '"latn_hypercube"', "design", "did you mean latin_hypercube?"),
        ('"latin_hypercube"', '"saltelli"', "design", "independent parameters"),
        (
            '{ "adc.reference" = -0.5 }',
            '{ "adc.reference" = -1.5 }',
            'correlation."noise.density"."adc.reference"',
            "from -1 to 1",
        ),
        ('{ "adc.reference" = -0.5 }', '{ "adc.refrence" = -0.5 }', "correlation", "did you mean adc.reference?"),
        ('"noise.density" = { "adc', '"source.value" = { "adc', "correlation", "cannot be correlated"),
        ('{ "adc.reference" = -0.5 }', "-0.5", 'correlation."noise.density"', "must be a table"),
        ('file = "lot.csv"', 'file = "lto.csv"', 'spread."source.value".file', "did you mean lot.csv?"),
        ('column = "offset"', 'column = "ofset"', 'spread."source.value".column', "did you mean offset?"),
        ("weights = [3, 1]", "weights = [3]", 'spread."filter.corner_frequency".weights', "2 numbers"),
        ("bias = 0.5", "bais = 0.5", "stop.bais", "did you mean bias?"),
        ("bias = 0.5", "bias = -1", "stop.bias", "at least 0"),
    ],
)
def test_mistakes_in_designs_and_distributions(old: str, new: str, key: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "lot.csv").write_text("offset\n1\n")
    text = changed(RICH, old, new)
    with pytest.raises(ModelError) as caught:
        study(tmp_path, text)
    (problem,) = caught.value.problems
    assert problem.key == key
    assert said in str(problem)
    assert problem.line == (line_of(text, "[study.correlation]") if key == "correlation" else line_of(text, new))


@pytest.mark.exhaustive
def test_correlated_parameters_follow_each_other(tmp_path: Path) -> None:
    (tmp_path / "lot.csv").write_text("offset\n1\n2\n")
    made = study(tmp_path, RICH).changed(runs=2000, seed=3)
    drawn = [made.drawn(k)[0] for k in range(2000)]
    gains, noises = (np.array([at[name] for at in drawn]) for name in ("adc.reference", "noise.density"))
    assert np.corrcoef(gains, np.log(noises))[0, 1] == pytest.approx(-0.5, abs=4 * 0.75 / np.sqrt(2000))
    assert np.std(np.log(noises)) == pytest.approx(0.1, rel=4 / np.sqrt(4000))
    assert sum(at["filter.corner_frequency"] == 100.0 for at in drawn) == 1500  # strata: exactly three in four


def test_noise_and_drift_are_shared_within_a_group_of_saltelli(tmp_path: Path) -> None:
    text = changed(STUDY, "seed = 11", 'seed = 11\ndesign = "saltelli"')
    made = study(tmp_path, text)  # two spread parameters, two points of a sweep
    assert [made.peer(run) for run in range(10)] == [0, 1, 0, 1, 0, 1, 0, 1, 2, 3]
    aged = [[at["adc.reference"] for at in made.drawn(run)] for run in range(0, 8, 2)]
    assert len({round(at[2] / at[0], 12) for at in aged}) == 1
    assert [study(tmp_path).peer(run) for run in (0, 7, 11)] == [0, 7, 11]


def test_a_driven_parameter_no_measures_no_study_and_no_graph_are_refused(tmp_path: Path) -> None:
    driven = changed(STUDY, '    "filter.output', '    "filter.output -> adc.reference",\n    "filter.output')
    for text, said in (
        (driven, "is driven by filter.output"),
        (STUDY.replace("[measures]", "[ignored]"), "unknown key"),
        (STUDY.partition("[study]")[0], "the graph has no study"),
        ("runs = 3\n", "the study names no graph"),
        ('graph = "../up.toml"\n', "outside the folder"),
    ):
        with pytest.raises(ModelError, match=said):
            study(tmp_path, text)
    graph, _, _ = STUDY.partition("[measures]")
    blocks = STUDY[STUDY.index("[blocks]") : STUDY.index("[study]")]
    with pytest.raises(ModelError, match="the graph has no measures"):
        Study(read_graph_text(graph + blocks))


@pytest.mark.exhaustive
def test_values_at_the_epochs_have_the_moments_of_the_laws(tmp_path: Path) -> None:
    """A ramp of 20 +- 5 ppm and a walk of 9 ppm in a year, over a spread of 200 ppm; four standard errors."""
    made = study(tmp_path).changed(runs=4000, seed=1)
    drawn = [made.drawn(2 * sensor) for sensor in range(4000)]
    new, old = (np.array([at[epoch]["adc.reference"] for at in drawn]) for epoch in (0, 2))
    change = (old / new - 1.0) * 1e6
    assert (new / 5.0 - 1.0).std() * 1e6 == pytest.approx(200.0, rel=4 / np.sqrt(8000))
    assert change.mean() == pytest.approx(20.0, abs=4 * np.hypot(5.0, 9.0) / np.sqrt(4000))
    assert change.std() == pytest.approx(np.hypot(5.0, 9.0), rel=4 / np.sqrt(8000))


LIMITED = """\
rate = "1 kHz"
samples = 1
wires = ["volts.output -> adc.voltage", "source.output -> error.first", "offset.output -> error.second"]
measures.error = { signal = "error.output", statistic = "last" }
measures.kept = { signal = "source.output", statistic = "last" }
blocks.source = { kind = "Constant", value = 1 }
blocks.offset = { kind = "Constant" }
blocks.error = { kind = "Difference" }
blocks.volts = { kind = "Constant", unit = "V" }
blocks.adc = { kind = "AnalogToDigital" }
[study]
runs = 50
epochs = { ages = ["0 h", "1 year", "2 year"] }
spread = { "source.value" = { normal = 0.1 } }
drift = { "source.value" = { random_walk = "0.001 1/sqrt(year)" } }
recalibration = { every = "never", carried = { "offset.value" = "kept" } }
limits.error = { at_least = -0.1, at_most = 0.1FROM }
"""


@pytest.mark.defect(
    "F7", before="yield 0 %: the first epoch is not calibrated", after="from = AGE, and a note of check"
)
def test_limits_count_from_an_age_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from proofmass.runner.command_line import main
    from proofmass.runner.studies.whole.study import run_study

    path = tmp_path / "study.toml"
    path.write_text(LIMITED.replace("FROM", ""))
    assert run_study(read_study(path), engine="python").yields()["error"] == 0.0
    assert main(["check", str(path)]) == 0
    assert "limits.error: counts the first epoch too" in capsys.readouterr().out
    path.write_text(LIMITED.replace("FROM", ', from = "1 year"'))
    study = read_study(path)
    result = run_study(study, engine="python")
    assert result.yields() == {"error": 1.0, "all limits": 1.0}
    assert main(["check", str(path)]) == 0
    assert "limits.error" not in capsys.readouterr().out
    again = read_study_text(write_study(study))
    assert again.limits == study.limits
    assert again.limits["error"].start == 31557600.0
    path.write_text(LIMITED.replace("FROM", ', from = "3 year"'))
    with pytest.raises(ModelError, match="no epoch is so old"):
        read_study(path)


def test_a_change_is_relative_to_the_first_epoch_that_counts(tmp_path: Path) -> None:
    from proofmass.runner.studies.shown.report import worst_runs
    from proofmass.runner.studies.whole.study import run_study

    text = LIMITED.replace("at_least = -0.1, at_most = 0.1FROM", 'change = 0.5, from = "1 year"')
    (tmp_path / "study.toml").write_text(text)
    result = run_study(read_study(tmp_path / "study.toml"), engine="python")
    _, first, second = result["error"].T
    kept = abs(second - first) <= 0.5 * abs(first)
    assert result.yields()["error"] == kept.mean()
    assert {worst.epoch for worst in worst_runs(result, "error", 5)} <= {1, 2}


@pytest.mark.parametrize(
    ("key", "said"), [("adc.bits", "is an integer, not a number"), ("source.unit", "is a text, not a number")]
)
def test_what_cannot_vary_says_why(key: str, said: str, tmp_path: Path) -> None:
    text = LIMITED.replace("FROM", "").replace('"source.value" = { normal = 0.1 }', f'"{key}" = {{ normal = 1 }}')
    with pytest.raises(ModelError, match=said) as caught:
        read_study_text(text)
    assert "sweep it" in caught.value.problems[0].hint
