"""The table `[tune]`: read with units, refused with every problem at once, and described by the schema."""

import tomllib
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.tuning.build import tuning_of
from proofmass.graphs.tuning.reader import read_tuning
from proofmass.graphs.tuning.tuning import Free
from tests.by_hand.design_texts import INTEGRATING, TUNE
from tests.by_hand.graph_schema import VALIDATOR
from tests.by_hand.graph_texts import changed, problems_of

TEXT = INTEGRATING + TUNE


def test_it_is_read_with_units(tmp_path: Path) -> None:
    path = tmp_path / "loop.toml"
    more = '[tune.points]\nweak = { "wanted.amplitude" = "50" }\n[tune.tolerances]\n"plant.gain" = "10 %"\n'
    path.write_text(TEXT + more, encoding="utf-8")
    tuning = read_tuning(path)
    assert tuning.free["controller.gain"].logarithmic, "its bounds are three decades apart"
    assert tuning.goals["phase"].at_least == 60.0
    assert tuning.goals["fast"].maximise
    assert tuning.points["weak"] == {"wanted.amplitude": 50.0}
    cases = tuning.cases()
    assert set(cases) == {"weak, corner 1", "weak, corner 2"}
    assert [factors["plant.gain"] for _, factors in cases.values()] == pytest.approx([0.9, 1.1])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("at_least = 1.0, at_most = 1000.0", "at_least = 5.0, at_most = 1.0", "leaves nothing free"),
        ("at_least = 1.0, at_most = 1000.0", "at_least = 1.0", "has no at_most"),
        ("controller.gain", "controler.gain", "did you mean controller"),
        ('figure = "phase_margin"', 'figure = "fase_margin"', "did you mean phase_margin"),
        ('loop = "main", figure = "phase', 'loop = "mian", figure = "phase', "did you mean main"),
        ("maximise = true", "maximise = true, minimise = true", "must say what is wanted"),
        ("maximise = true", 'maximise = true, at_least = "1 V"', "V is m^2*kg/s^3/A, not 1/s"),
        ('figure = "bandwidth", ', "", "there is no such figure"),
        ('loop = "main", figure = "bandwidth"', 'noise = "plant.output", band = ["5 Hz", "1 Hz"]', "empty"),
        ('loop = "main", figure = "bandwidth"', 'measure = "botom"', "no such measure"),
        ('"60 deg"', '"60 deg", gain = 3', "unknown key"),
        ('loop = "main", figure = "bandwidth", maximise', "yield = true, maximise", "there is no study with limits"),
        ("maximise = true", "maximise = true, soft = true", "leave soft out, or give a limit"),
        ("maximise = true", 'at_least = "5 Hz", at_most = "1 Hz"', "nothing can meet it"),
        ('"bandwidth", maximise', '"settling_time", maximise', "a settling time has no upper end"),
        ('"phase_margin", at_least = "60 deg"', '"gain_margin", at_least = "6 V"', 'write it as "6 dB"'),
        ("at_most = 1000.0", 'at_most = 1000.0, scale = "logaritmic"', "did you mean logarithmic?"),
        ("at_least = 1.0, at_most", 'scale = "logarithmic", at_least = -1.0, at_most', "needs positive bounds"),
        ("[tune.goals]", '[tune.tolerances]\n"plant.gain" = 1.5\n[tune.goals]', 'write a part of the value, as "5 %"'),
        ("[tune.free]", '[tune]\nages = ["1 V"]\n[tune.free]', 'write ages = ["0 h", "15 year"]'),
        ("[tune.free]", '[tune]\nages = "1 h"\n[tune.free]', "must be a list of ages"),
        ('"controller.gain" = { at_least = 1.0', '"hiss.density" = { at_least = -1.0', "the block does not take it"),
        ("[tune.free]", '[tune]\nat = "soon"\n[tune.free]', "not a number followed by a unit"),
    ],
)
def test_a_mistake_is_named_with_its_line(old: str, new: str, words: str) -> None:
    found = [str(problem) for problem in problems_of(changed(TUNE, old, new).join([INTEGRATING, ""]))]
    assert len(found) >= 1
    assert any(words in text for text in found), found
    assert all("model.toml:" in text for text in found)


def test_all_mistakes_come_at_once() -> None:
    wrong = TUNE.replace("phase_margin", "fase").replace("at_least = 1.0", "at_least = -1.0")
    wrong = wrong.replace("[tune.free]", "[tune]\nstarts = 0\nsample = 3\n[tune.free]").replace("1000.0 }", "-2 }")
    assert len(problems_of(INTEGRATING + wrong)) == 4


def test_mistakes_of_the_study_come_beside_those_of_the_tuning() -> None:
    """Those of a study that the tuning asks for come once, and the tuning waits for them."""
    study = '[study]\nruns = 4\nspread = { "plant.gian" = { uniform = 0.1 } }\n'
    wrong = TUNE.replace("phase_margin", "fase")
    assert len(problems_of(INTEGRATING + wrong + study)) == 2
    assert len(problems_of(INTEGRATING + wrong + "good = { yield = true, maximise = true }\n" + study)) == 1


def test_a_graph_without_the_table_says_what_to_add(tmp_path: Path) -> None:
    path = tmp_path / "loop.toml"
    path.write_text(INTEGRATING, encoding="utf-8")
    with pytest.raises(ModelError, match=r"no table \[tune\]"):
        read_tuning(path)


def test_the_schema_takes_it_and_refuses_misspellings() -> None:
    assert VALIDATOR.is_valid(tomllib.loads(TEXT))
    for old, new in (("at_most", "atmost"), ("figure", "figur"), ("maximise", "maximize"), ("goals", "gaols")):
        assert not VALIDATOR.is_valid(tomllib.loads(TEXT.replace(old, new))), new


def test_python_tables_are_those_of_the_file() -> None:
    graph = read_graph_text(INTEGRATING)
    tables = tomllib.loads(TUNE)["tune"]
    assert tuning_of(graph, **tables).goals.keys() == {"phase", "fast"}
    with pytest.raises(ModelError, match="corners"):
        tuning_of(
            graph,
            **tables,
            tolerances=dict.fromkeys(("plant.gain", "controller.gain"), "1 %"),
            points={str(i): {} for i in range(99)},
        )


def test_it_is_written_and_reads_back(tmp_path: Path) -> None:
    goals = """
quiet = { noise = "plant.output", input = "wanted.output", band = ["1 Hz", "100 Hz"], at_most = 0.02, soft = true }
calm = { loop = "main", figure = "overshoot", at_most = "15 %" }
wide = { response = "plant.output", input = "wanted.output", frequency = "30 Hz", at_least = 0.7 }
level = { bias = "plant.output", input = "wanted.output", at_least = -1, at_most = 1 }
end = { measure = "end", at_least = 0.9 }
good = { yield = "end", at_least = "90 %" }
all = { yield = true, maximise = true }
[tune.points]
weak = { "controller.gain" = "50" }
free = {}
[tune.tolerances]
"plant.gain" = "10 %"
[study]
runs = 8
spread = { "plant.gain" = { normal = "1 %", relative = true } }
limits = { end = { at_least = 0.9 } }
"""
    path, again = tmp_path / "loop.toml", tmp_path / "again.toml"
    settings = "[tune]\nat = '5 ms'\nseed = 3\n[tune.free]"
    path.write_text((TEXT + goals).replace("[tune.free]", settings), encoding="utf-8")
    tuning = read_tuning(path)
    again.write_text(write_graph(tuning), encoding="utf-8")
    assert tomllib.loads(again.read_text())["tune"]["goals"]["calm"]["at_most"] == 15.0
    read = read_tuning(again)
    assert read == tuning
    assert (read.at, read.seed, read.study) == ("5 ms", 3, tuning.study)
    assert VALIDATOR.is_valid(tomllib.loads(again.read_text()))


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("[tune]\nstarts = 3\n", "free: names no parameter"),
        ('[tune.free]\n"controller.gain" = { at_least = 1.0, at_most = 2.0 }\n', "goals: names no goal"),
    ],
)
def test_a_table_without_parameters_or_goals_says_what_to_add(table: str, said: str) -> None:
    (problem,) = problems_of(f"{INTEGRATING}\n{table}")
    assert f"{problem.key}: {problem.message}" == said
    assert problem.hint.startswith(f"add [tune.{problem.key}] and below it ")


def test_axes() -> None:
    """Halfway between 1 and 100 lies 10 on a logarithmic axis, and 50.5 on a linear one; slopes by differences."""
    for free, half in ((Free(1.0, 100.0, True), 10.0), (Free(1.0, 100.0, False), 50.5)):
        assert free.value(0.5) == pytest.approx(half)
        assert free.part(half) == pytest.approx(0.5)
        assert (free.part(0.1), free.part(1e3)) == (0.0, 1.0)
        assert free.slope(half) == pytest.approx((free.value(0.5 + 1e-6) - free.value(0.5 - 1e-6)) / 2e-6)


def test_ages_multiply_the_cases_and_drift_moves_them(tmp_path: Path) -> None:
    drift = '[tune]\nages = ["0 h", "1 year"]\n[study]\nruns = 4\nepochs = { ages = ["0 h", "1 year"] }\n'
    drift += 'drift = { "plant.gain" = { ramp = "10 %/year", relative = true } }\n'
    drift += 'spread = { "hiss.density" = { uniform = 1e-4 } }\n'
    path = tmp_path / "loop.toml"
    path.write_text(INTEGRATING + drift.replace("[study]", f"{TUNE}[study]"))
    tuning = read_tuning(path)
    assert {name: age for name, (_, _, age) in tuning.aged_cases().items()} == {"0 h": 0.0, "1 year": 31557600.0}
    now, slopes = tuning.aged({"plant.gain": 2.0}, 31557600.0)
    assert now == pytest.approx({"plant.gain": 2.2})
    assert slopes == pytest.approx({"plant.gain": 1.1})
    new, _ = tuning.aged({}, 0.0)
    assert new == {"plant.gain": 1.0}
    assert [goal.wanted for goal in tuning.goals.values()] == ["at least 60 deg", "as high as possible"]


def test_a_yield_has_the_ages_of_its_study() -> None:
    goal = "[tune.goals]\ngood = { yield = true, maximise = true }\n"
    text = changed(TUNE, "[tune.goals]\n", goal).replace("[tune.free]", '[tune]\nages = ["1 year"]\n[tune.free]')
    study = '[study]\nruns = 4\nepochs = { ages = ["0 h", "1 year"] }\nlimits = { end = { at_least = 0.9 } }\n'
    study += 'drift = { "plant.gain" = { ramp = "10 %/year", relative = true } }\n'
    (problem,) = problems_of(INTEGRATING + text + study)
    assert str(problem).endswith(
        "ages: a yield has the ages of its study\n  got:      ['1 year']\n  hint:     leave ages out"
    )


@pytest.mark.defect("S913", before="tuned although every operating point sets it", after="refused")
def test_what_every_operating_point_sets_is_not_free() -> None:
    tables = tomllib.loads(TUNE)["tune"]
    graph = read_graph_text(INTEGRATING)
    with pytest.raises(ModelError, match="leaves nothing free") as refused:
        tuning_of(graph, **tables, points={"weak": {"controller.gain": 50.0}, "strong": {"controller.gain": 70.0}})
    assert [problem.key for problem in refused.value.problems] == ['free."controller.gain"']
