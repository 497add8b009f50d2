"""Two files compared: variants of studies and goals of tunings, each with its key."""

from pathlib import Path

import pytest

from proofmass.runner.comparison.files import file_differences
from tests.by_hand.design_texts import INTEGRATING, TUNE

STUDY = """
[study]
runs = 5
spread = { "plant.gain" = { normal = "1 %", relative = true } }
limits = { end = { at_least = 0.9 } }
[study.variants]
slow = { set = { "controller.gain" = 50.0 } }
fast = { set = { "controller.gain" = 150.0 } }
"""
TEXT = INTEGRATING + TUNE + STUDY
MUTATIONS = {
    ("150.0", "160.0"): "study.variants.fast.blocks.controller.gain",
    ("fast = { set", "quick = { set"): "study.variants.fast study.variants.quick",
    ("runs = 5", "runs = 6"): "study.runs",
    ('normal = "1 %"', 'normal = "2 %"'): "study.spread.plant.gain",
    ("at_least = 0.9", "at_least = 0.8"): "study.limits.end",
    ('"60 deg"', '"61 deg"'): "tune.goals.phase",
    ("at_most = 1000.0", "at_most = 900.0"): "tune.free.controller.gain",
    ("[tune.free]", "[tune]\nseed = 4\n[tune.free]"): "tune.seed",
    ("1e-3 1/sqrt", "2e-3 1/sqrt"): "blocks.hiss.density",
    (TUNE, ""): "tune",
    (STUDY, ""): "study",
}


@pytest.mark.parametrize("mutation", MUTATIONS)
@pytest.mark.friendly(36, "each change of a file, by its key alone")
def test_each_mutation_is_named_with_its_key_alone(mutation: tuple[str, str], tmp_path: Path) -> None:
    assert TEXT.count(mutation[0]) == 1
    before, after = tmp_path / "before.toml", tmp_path / "after.toml"
    before.write_text(TEXT, encoding="utf-8")
    after.write_text(TEXT.replace(*mutation), encoding="utf-8")
    assert [d.key for d in file_differences(before, after, None)] == MUTATIONS[mutation].split()
    assert not file_differences(before, before, None)


def test_a_graph_and_a_study_differ_by_their_graphs_too(tmp_path: Path) -> None:
    before, after = tmp_path / "before.toml", tmp_path / "after.toml"
    before.write_text(INTEGRATING, encoding="utf-8")
    after.write_text(INTEGRATING.replace("1e-3 1/sqrt", "2e-3 1/sqrt") + STUDY, encoding="utf-8")
    assert [d.key for d in file_differences(before, after, None)] == ["blocks.hiss.density", "study"]


def test_studies_without_a_common_variant(tmp_path: Path) -> None:
    """The first variants of both are compared: 50 of the gain and 160, beside what both studies say."""
    files = [tmp_path / "before.toml", tmp_path / "after.toml"]
    other = STUDY.replace("slow = ", "steep = ").replace("50.0", "160.0").replace("fast = { set", "flat = { set")
    for file, study in zip(files, (STUDY, other.replace("runs = 5", "runs = 6")), strict=True):
        file.write_text(INTEGRATING + study, encoding="utf-8")
    found = file_differences(*files, None)
    assert {d.key: (d.before, d.after) for d in found} == {
        "blocks.controller.gain": ("50.0", "160.0"),
        "study.runs": ("5", "6"),
        "study.variants.slow": ("there", ""),
        "study.variants.fast": ("there", ""),
        "study.variants.steep": ("", "there"),
        "study.variants.flat": ("", "there"),
    }


RECORDED = """
name = "two recordings"
rate = "1 kHz"
wires = ["played.output -> sum.first", "other.output -> sum.second"]
blocks.played = { kind = "RecordedSignal", file = "a.csv", column = "v", unit = "V" }
blocks.other = { kind = "RecordedSignal", file = "b.csv", column = "v", unit = "V" }
blocks.sum = { kind = "Sum", unit = "V" }
"""


@pytest.mark.defect("S902", before="they mean the same", after="the block whose recording holds other numbers")
def test_recordings_of_one_name_with_other_numbers(tmp_path: Path) -> None:
    """Written otherwise, numbers are the same."""
    files = []
    for name, numbers in (("before", "0,1\n1,2\n"), ("same", "0,1.0\n1.0,2e0\n"), ("after", "0,1\n1,3\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.csv").write_text("time,v\n0,1\n1,2\n")
        (tmp_path / name / "b.csv").write_text("time,v\n" + numbers)
        files.append(tmp_path / name / "graph.toml")
        files[-1].write_text(RECORDED)
    assert file_differences(files[0], files[1], None) == []
    (found,) = file_differences(files[0], files[2], None)
    assert found.key == "blocks.other.file"
    assert found.before.startswith("b.csv, numbers ")
    (files[2].parent / "a.csv").unlink()
    lost = {found.key: found.after for found in file_differences(files[0], files[2], None)}
    assert lost["blocks.played.file"] == "there is no such file"


@pytest.mark.defect("S994", before="they mean the same, but stop after other runs", after="the key and both numbers")
def test_when_a_study_stops_is_compared(tmp_path: Path) -> None:
    files = [tmp_path / "before.toml", tmp_path / "after.toml"]
    for file, half in zip(files, (0.1, 0.2), strict=True):
        file.write_text(f"{INTEGRATING}{STUDY}[study.stop]\nend = {half}\n", encoding="utf-8")
    found = file_differences(*files, None)
    assert [(d.key, d.before, d.after) for d in found] == [("study.stop.end", "0.1", "0.2")]
