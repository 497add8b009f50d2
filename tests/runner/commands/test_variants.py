"""Variants of a study: named designs, integers and laws of drift swept; each a study with the same sensors."""

import json
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.studies.study_reader import read_study, read_variants
from proofmass.graphs.tuning.reader import read_tuning
from proofmass.runner.command_line import main
from proofmass.runner.comparison.variants import VariantComparison, folders_of
from proofmass.runner.studies.shown.curves import variant_pictures
from proofmass.runner.studies.whole.study import replay, run_study
from tests.by_hand.study_texts import STUDY

BASE = STUDY.partition("[study.sweep]")[0] + STUDY[STUDY.index("[study.epochs]") :]
NAMED = (
    BASE
    + """
[study.variants.fine]
[study.variants.coarse]
set = { "adc.bits" = 8 }
[study.variants.steady]
drift = { "adc.reference" = { ramp = "1 ppm/year", relative = true } }
"""
)
SWEPT = (
    BASE
    + """
[study.sweep]
"adc.bits" = [8, 12]
"drift.adc.reference.ramp" = ["20 ppm/year", "40 ppm/year"]
"""
)


def written(folder: Path, text: str) -> Path:
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


@pytest.mark.defect("S905", before="the first of all variants, without a word", after="a message names them")
@pytest.mark.parametrize(
    ("text", "named"),
    [(NAMED, "fine, coarse, steady"), (SWEPT, "adc.bits = 8, drift.adc.reference.ramp = 20 ppm/year")],
)
def test_a_file_of_variants_is_no_single_study(tmp_path: Path, text: str, named: str) -> None:
    path = written(tmp_path, text)
    for call in (run_study, lambda study: replay(study, 0)):
        with pytest.raises(ModelError, match="the study has variants") as refused:
            call(path)
        assert refused.value.problems[0].got.startswith(named)
        assert refused.value.problems[0].file == str(path)
    tuned = '\n[tune.free]\n"gain.gain" = [0.5, 2.0]\n[tune.goals]\ngood = { yield = "bias", maximise = true }\n'
    with pytest.raises(ModelError, match="the study has variants"):
        read_tuning(written(tmp_path, text + tuned))


ALIKE = """
[study.variants."a b"]
[study.variants."A/B"]
limits = { bias = { at_most = -1.0 } }
[study.variants.".."]
limits = { bias = { at_least = -1.0 } }
"""


@pytest.mark.exhaustive
def test_variants_whose_names_are_alike_have_answers_of_their_own(tmp_path: Path) -> None:
    path, out = written(tmp_path, BASE.partition("[study.limits]")[0] + ALIKE), tmp_path / "out"
    words = ["montecarlo", str(path), "--runs", "1", "--engine", "python", "--no-report", "--out", str(out)]
    assert main([*words, "--format", "csv", "--quiet"]) == 0
    told = {
        folder.name: json.loads((folder / "study.json").read_text())["yield"]
        for folder in out.iterdir()
        if folder.is_dir()
    }
    assert told == {"a_b": {}, "A_B_2": {"bias": 0.0, "all limits": 0.0}, "variant": {"bias": 1.0, "all limits": 1.0}}
    assert sorted(tmp_path.iterdir()) == [out, path]


@pytest.mark.defect("S935", before="three variants in one folder, which told of the last", after="one for each")
def test_variants_whose_names_are_alike_have_folders_of_their_own() -> None:
    folders = folders_of(Path("out"), ["a b", "A/B", ".."])
    assert list(folders.values()) == [Path("out/a_b"), Path("out/A_B_2"), Path("out/variant")]


def test_folders_of_variants_have_names_that_file_systems_take() -> None:
    long = ", ".join(f"filter.taps = [{number}]" for number in range(40))
    names = [folder.name for folder in folders_of(Path("out"), ["größer", "более", long, long + "."]).values()]
    assert names[:2] == ["größer", "более"]
    assert len(set(names)) == 4
    assert max(map(len, names)) < 90


@pytest.mark.exhaustive
def test_named_designs_are_studies_of_the_same_sensors(tmp_path: Path) -> None:
    studies = read_variants(written(tmp_path, NAMED))
    assert list(studies) == ["fine", "coarse", "steady"]
    assert read_study(tmp_path / "study.toml") == studies["fine"]
    assert [s.flat.blocks["adc"].bits for s in studies.values()] == [12, 8, 12]  # type: ignore[attr-defined]
    assert studies["coarse"].drawn(3) == studies["fine"].drawn(3)
    year = 31557600.0
    assert studies["steady"].drift["adc.reference"].ramp == pytest.approx(1e-6 / year)
    assert studies["steady"].drawn(3)[0] == studies["fine"].drawn(3)[0], "new sensors are the same"
    alone = run_study(read_study(written(tmp_path, BASE.replace("bits = 12", "bits = 8"))), engine="python")
    assert run_study(studies["coarse"], engine="python").digest == alone.digest


def test_a_sweep_over_a_value_that_a_list_follows_makes_variants(tmp_path: Path) -> None:
    text = """\
rate = "1 kHz"
samples = 1
wires = ["source.output -> filter.input"]

[values]
stiffness = 2.0

[blocks]
source = { kind = "Constant" }
filter = { kind = "TransferFunction", denominator = [1.0, "= 3 * stiffness"] }

[measures]
last = { signal = "filter.output", statistic = "last" }

[study]
runs = 2

[study.sweep]
stiffness = [2.0, 4.0]
"""
    studies = read_variants(written(tmp_path, text))
    assert list(studies) == ["stiffness = 2.0", "stiffness = 4.0"]
    filters = [study.flat.blocks["filter"] for study in studies.values()]
    assert [block.denominator for block in filters] == [(1.0, 6.0), (1.0, 12.0)]  # type: ignore[attr-defined]


def test_a_sweep_over_integers_and_laws_makes_variants(tmp_path: Path) -> None:
    studies = read_variants(written(tmp_path, SWEPT))
    assert list(studies)[:2] == [
        "adc.bits = 8, drift.adc.reference.ramp = 20 ppm/year",
        "adc.bits = 8, drift.adc.reference.ramp = 40 ppm/year",
    ]
    assert len(studies) == 4
    ramps = [study.drift["adc.reference"].ramp for study in studies.values()]
    assert ramps[1] == pytest.approx(2.0 * ramps[0])
    assert [study.sweep for study in studies.values()] == [{}] * 4


@pytest.mark.exhaustive
def test_the_command_runs_and_compares_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = written(tmp_path, NAMED), tmp_path / "out"
    command = ["montecarlo", str(path), "--engine", "python", "--quiet"]
    assert main([*command, "--out", str(out), "--no-report"]) == 0
    said = capsys.readouterr().out
    assert "variant coarse" in said
    assert "coarse, after fine: means, compared sensor by sensor" in said
    data = json.loads((out / "variants.json").read_text())
    bias = [row for row in data["coarse"]["means"] if row["measure"] == "bias"]
    results = [run_study(study, engine="python") for study in read_variants(path).values()]
    assert bias[0]["difference"] == pytest.approx(float(np.mean(results[1]["bias"][:, 0] - results[0]["bias"][:, 0])))
    assert bias[0]["moved"], "16 times fewer codes"
    assert (out / "coarse" / "study.toml").is_file()
    assert (out / "variants.html").is_file()
    assert main([*command, "--variant", "coarse", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["digest"] == results[1].digest
    assert main([*command, "--variant", "rough"]) == 2
    assert main([*command, "--run", "1"]) == 2


@pytest.mark.exhaustive
def test_set_changes_the_graph_of_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, BASE)
    assert main(["montecarlo", str(path), "--engine", "python", "--quiet", "--set", "adc.bits=8", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["digest"]
    other = read_study(written(tmp_path, BASE.replace("bits = 12", "bits = 8")))
    assert found == run_study(other, engine="python").digest


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[study.variants]\ncheap = 3", "must be a table"),
        ("[study.variants.cheap]\nsets = {}", "did you mean set?"),
        ('[study.variants.cheap]\nset = { "adc.bist" = 8 }', "adc.bist"),
        ('[study.variants.cheap]\ndrift = { "adc.refrence" = { ramp = 1 } }', "did you mean reference?"),
        ('[study.sweep]\n"drift.adc.gain.ramp" = [1]', "nothing drifts by that name"),
        ('[study.sweep]\n"adc.bits" = 8', "must be a list of values"),
        ('[study.sweep]\n"adc.bits" = [8, 99]', "99"),
    ],
)
def test_a_mistake_is_named(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ModelError) as caught:
        read_variants(written(tmp_path, f"{BASE}\n{text}\n"))
    assert said in str(caught.value)
    assert "study.toml:" in str(caught.value)


@pytest.mark.exhaustive
def test_swept_integers_and_laws_have_curves_together(tmp_path: Path) -> None:
    """The bias of 12 bits is 16 times that of 8: a mean for each value, a curve for each value of the other."""
    studies = read_variants(written(tmp_path, SWEPT))
    results = {name: run_study(study, runs=4, engine="python") for name, study in studies.items()}
    charts = dict(variant_pictures(results))
    assert list(charts) == ["over adc.bits", "over drift.adc.reference.ramp"]
    bits, ramp = charts.values()
    assert bits.count("<svg") == 2, "a chart for each measure"
    assert "<title>bias over adc.bits</title>" in bits
    assert "drift.adc.reference.ramp = 20 ppm/year" in bits
    assert "drift.adc.reference.ramp [ppm/year]" in ramp
    assert "adc.bits = 12" in ramp
    assert not variant_pictures({name: results[next(iter(results))] for name in ("coarse", "fine")})
    VariantComparison(results).save(tmp_path)
    assert "over adc.bits" in (tmp_path / "variants.html").read_text(encoding="utf-8")
