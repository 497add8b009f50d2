"""The tool that changes the source: its changes, the tests that it takes, and what becomes of two of them."""

import ast
from pathlib import Path

import pytest

from tests.mutants import ROOT, chosen, examined, mutants, project_copied
from tests.nearest import Nearest

FILE = "blocks/arithmetic/rounding.py"
NEAR, FAR = "arithmetic/test_rounding.py", "magnetics/test_hall_element.py"
CRASHES = "tests/test_crash.py"


def test_every_change_is_one_place_of_a_file_that_still_parses() -> None:
    source = (ROOT / FILE).read_bytes()
    found = list(mutants(FILE))
    assert len(found) > 15
    for mutant in found:
        before, after = mutant.told(source)
        assert before != after
        ast.parse(mutant.text(source))
    told = {mutant.told(source) for mutant in found}
    assert ("above = value if value > low else low", "above = value if value >= low else low") in told
    assert ("return math.floor(value)", "return math.ceil(value)") not in told


def test_what_is_only_said_stays() -> None:
    """Words, annotations and assertions are not changed."""
    lines = {mutant.line for mutant in mutants("runner/program/build.py")}
    source = (ROOT / "runner/program/build.py").read_text().splitlines()
    assert not any(source[line - 1].strip().startswith(("assert", "raise", '"""')) for line in lines)


def test_looks_of_a_picture_stay() -> None:
    """Where a legend stands and how wide a line is, but not where it lies."""
    source = (ROOT / "runner/design/worst/plot.py").read_bytes()
    told = {mutant.told(source)[1] for mutant in mutants("runner/design/worst/plot.py")}
    assert not any("(0.8*2)" in line or "(9.5*2)" in line or "(0.75*2)" in line for line in told)
    assert "nominal = case.nominal / factor" in told


@pytest.mark.exhaustive
def test_the_tests_of_its_name_stand_nearest_to_a_file() -> None:
    nearest = Nearest(measured=False)
    assert nearest.of(FILE)[0] == "tests/blocks/arithmetic/test_rounding.py"
    assert "tests/runner/program/test_tangents.py" in nearest.of("runner/program/tangents.py")
    assert nearest.of("runner/program/walk.py"), "it is imported by way of others"
    assert nearest.of("runner/design/modulators/graph.py"), "no test imports it: those of its folder"
    assert nearest.of(FILE)[1] == "tests/runner/derivatives/test_dual_functions.py", "it imports the file"
    assert len({mutant.file for mutant in chosen(20, 7, ["blocks/arithmetic", "runner/program"])}) > 10


@pytest.mark.exhaustive
def test_a_change_is_noticed_by_some_tests_and_not_by_others() -> None:
    source = (ROOT / FILE).read_bytes()
    changed = "above = value if value > low else low", "above = value if value >= low else low"
    mutant = next(mutant for mutant in mutants(FILE) if mutant.told(source) == changed)
    with project_copied() as copy:
        near, far = (examined(mutant, copy, [f"tests/blocks/{name}"]) for name in (NEAR, FAR))
        assert (copy / FILE).read_bytes() == source
        (copy / CRASHES).write_text("import os\n\n\ndef test_crash():\n    os.kill(os.getpid(), 11)\n")
        crash = examined(mutant, copy, [CRASHES])
    assert near.startswith(f"tests/blocks/{NEAR}::")
    assert far == ""
    assert crash == CRASHES


BOUNDS = """\
SMALL = 1e-9
MANY = 40
LEAST = 2.0**-40


def bounded(x, y):
    a = -1.5 if x < -1.5 else 3 if x > 3 else x
    b = x if x > 0.0 else 0.0
    c = x if x < 3 else y
    return a < MANY, b < SMALL * y, abs(c) >= LEAST, x <= 1e-6, x > 2.5
"""


def test_a_bound_changes_only_where_some_number_meets_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The other comparison at a tolerance; nothing at a clip, but at 0, where signs differ."""
    (tmp_path / "bounds.py").write_text(BOUNDS)
    monkeypatch.setattr("tests.mutants.ROOT", tmp_path)
    source = BOUNDS.encode()
    changes = {mutant.told(source)[1] for mutant in mutants("bounds.py") if mutant.new.startswith(("<", ">"))}
    last = BOUNDS.splitlines()[-1].strip()
    numbers = {mutant.new for mutant in mutants("bounds.py") if mutant.new.startswith("(")}
    assert {"(1e-09*1e6)", "(1e-06*1e6)", "(40*2)", "(2.5*2)", "(1.0)"} <= numbers
    assert changes == {
        "b = x if x >= 0.0 else 0.0",
        "c = x if x <= 3 else y",
        last.replace("a < MANY", "a <= MANY"),
        last.replace("b < SMALL", "b >= SMALL"),
        last.replace(">= LEAST", "< LEAST"),
        last.replace("<= 1e-6", "> 1e-6"),
        last.replace("> 2.5", ">= 2.5"),
    }
