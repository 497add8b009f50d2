"""Every value of graphs, studies and tunings in turn is of another kind: it is read, or refused by a problem.

Each table and entry becomes a number, a text, a list or a table, and is left out. Messages name the key or the line.
"""

import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.graphs.tuning.reader import read_tuning
from tests.by_hand.design_texts import INTEGRATING
from tests.by_hand.study_texts import CALIBRATED, RICH, STUDY

FULL = """\
name = "a loop with all that a graph may say"
rate = "1 kHz"
samples = 40
seed = 3
wires = ["set.output -> error.first", "back.output -> error.second", "error.output -> filter.input",
    "filter.output -> adc.voltage", "adc.number -> control.input", "control.output -> back.input"]
probes = ["adc.code", { signal = "filter.output", every = 2 }]
exports = { code = "adc.code", reference = "adc.reference" }

[values]
corner = "100 Hz"
twice = "= 2 * corner"

[formulas]
"control.gain" = "= corner / 100"

[integration]
method = "runge_kutta_4"
substeps = 4

[loops.main]
open_at = "error.output"
gain_margin = "3 dB"
phase_margin = "30 deg"

[measures]
mean = { signal = "adc.number", statistic = "mean", from = "5 ms", until = "30 ms" }
high = { signal = "filter.output", statistic = "percentile", percent = 90, unit = "mV" }
ratio = { formula = "= mean / mean", unit = "%" }

[requirements]
R1 = { quantity = "mean", at_least = -1, at_most = 1, text = "small" }
R2 = { quantity = "main.phase_margin", at_least = "3 deg", at = "settled", tolerances = { "control.gain" = "5 %" } }
R3 = { quantity = { noise = "adc.number", band = ["1 Hz", "100 Hz"] }, at_most = 1 }
R4 = { quantity = { response = "adc.number", input = "set.output", figure = "gain", frequency = "1 Hz" }, at_most = 9 }

[blocks]
set = { kind = "Constant", value = "1 V", unit = "V" }
error = { kind = "Difference", unit = "V" }
filter = { kind = "LowPass", corner_frequency = "= twice", input_unit = "V", output_unit = "V" }
adc = { kind = "AnalogToDigital", bits = 12, reference = "5 V" }
control = { kind = "DiscreteIntegrator", gain = 1.0, output_unit = "1", rate = "500 Hz", clock_offset = "1 ms" }
back = { kind = "Gain", gain = "1 V", output_unit = "V" }
"""
AGEING = (
    STUDY.partition("[study.drift]")[0]
    + """\
[study.missions]
car = { phases = [{ temperature = "253 K", for = "8 h" }, { temperature = "353 K", for = "16 h" }] }
measured = { file = "chamber.csv", time = "t", temperature = "T" }
truck = { points = [["0 h", "253 K"], ["8 h", "353 K"], ["24 h", "253 K"]] }

[study.drift]
"adc.reference" = { arrhenius = "4 ppm/year", activation_energy = "0.6 eV", mission = "car", relative = true }
"source.value" = { ramp = "20 uV/year", random_walk = "9 uV/sqrt(year)" }

[study.changes]
moved = { measure = "bias", since = "1000 h", relative = true }

[study.limits]
bias = { at_least = 0, at_most = 5, change = "100 ppm" }

[study.variants]
fine = {}
cheap = { set = { "adc.bits" = 10 }, spread = { "adc.reference" = { triangular = "1 %", relative = true } } }
"""
)
TUNED = (
    INTEGRATING
    + """
[study]
runs = 4
spread = { "controller.gain" = { uniform = "5 %", relative = true } }
drift = { "controller.gain" = { ramp = "1 %/year", relative = true } }
limits = { end = { at_least = 0.5 } }
epochs = { ages = ["0 h", "15 year"] }

[tune]
at = "settled"
starts = 2
samples = 10
seed = 1
ages = ["0 h", "15 year"]
free = { "controller.gain" = { at_least = 1.0, at_most = 1000.0, scale = "logarithmic" } }
points = { hot = { "plant.gain" = 1.1 } }
tolerances = { "plant.gain" = "5 %" }

[tune.goals]
phase = { loop = "main", figure = "phase_margin", at_least = "60 deg", soft = true }
step = { response = "plant.output", input = "wanted.output", figure = "overshoot", at_most = "60 %" }
hiss = { noise = "plant.output", input = "wanted.output", band = ["1 Hz", "100 Hz"], minimise = true }
scale = { scale_factor = "plant.output", input = "wanted.output", at_least = 0.9, at_most = 1.1 }
high = { measure = "top", at_most = 2 }
"""
)
WRONG: list[Any] = [  # None: left out
    None,
    0, -1, 1.5, float("inf"), True, "", "x", "1 V", "= x", [], [1], ["a", "b", "c"], [[1, 2]], {}, {"a": 1}, {"a": {}}
]  # fmt: skip


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(key)} = {toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return str(value).lower() if isinstance(value, bool) else f"'{value}'" if isinstance(value, str) else repr(value)


def places(table: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    for key, entry in table.items() if isinstance(table, dict) else enumerate(table[:1]):
        yield (*path, key)
        if isinstance(entry, dict | list):
            yield from places(entry, (*path, key))


def changed(table: Any, path: tuple[Any, ...], wrong: Any) -> Any:
    """A copy with another value at a place; without it where that is None."""
    first, *rest = path
    copy = dict(table) if isinstance(table, dict) else dict(enumerate(table))
    copy[first] = changed(copy[first], tuple(rest), wrong) if rest else wrong
    copy = {key: entry for key, entry in copy.items() if entry is not None}
    return copy if isinstance(table, dict) else list(copy.values())


def written(table: Mapping[str, Any]) -> str:
    return "".join(f"{toml(key)} = {toml(entry)}\n" for key, entry in table.items())


def of_graph(text: str, folder: Path) -> None:
    problems = [problem for problem in check(read_graph_text(text, folder=str(folder))) if not problem.note]
    if problems:
        raise ModelError(problems)


def of_study(text: str, folder: Path) -> None:
    read_study_text(text, folder=str(folder))


def of_tuning(text: str, folder: Path) -> None:
    (folder / "graph.toml").write_text(text)
    read_tuning(folder / "graph.toml")


TEXTS: list[tuple[Callable[[str, Path], None], str, str]] = [
    (of_graph, FULL, ""), (of_study, RICH, "study"), (of_study, CALIBRATED, "study"), (of_study, AGEING, "study"),
    (of_tuning, TUNED, "tune"),
]  # fmt: skip
PARTS = 80  # of the changes of each text


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("files")
    (place / "lot.csv").write_text("offset [V]\n" + "\n".join(f"{n / 1000}" for n in range(12)) + "\n")
    (place / "chamber.csv").write_text("t [h],T [K]\n" + "\n".join(f"{n},{300 + n % 5}" for n in range(24)) + "\n")
    return place


@pytest.mark.parametrize(("read", "text", "table"), TEXTS)
def test_what_is_changed_can_be_read(read: Callable[[str, Path], None], text: str, table: str, folder: Path) -> None:
    read(written(tomllib.loads(text)), folder)


@pytest.mark.exhaustive(but=20)
@pytest.mark.parametrize("part", range(PARTS))
@pytest.mark.parametrize(("read", "text", "table"), TEXTS)
def test_a_value_of_another_kind_is_read_or_refused(
    read: Callable[[str, Path], None], text: str, table: str, part: int, folder: Path
) -> None:
    """Any other exception than a `ModelError` ends the test."""
    whole = tomllib.loads(text)
    changes = [(path, wrong) for path in places(whole) if path[0] == (table or path[0]) for wrong in WRONG]
    for path, wrong in changes[part::PARTS]:
        try:
            read(written(changed(whole, path, wrong)), folder)
        except ModelError as error:
            for problem in error.problems:
                assert problem.message, (path, wrong)
                assert problem.key or problem.line, (path, wrong, str(problem))
                assert problem.got or problem.expected or problem.hint, (path, wrong, str(problem))


@pytest.mark.parametrize(
    ("read", "text", "path"),
    [
        (of_graph, FULL, ("requirements", "R4", "quantity", "figure")),
        (of_tuning, TUNED, ("tune", "goals", "phase", "figure")),
        (of_study, RICH, ("study", "spread", "source.value", "column")),
        (of_study, AGEING, ("study", "missions", "measured", "time")),
    ],
)
@pytest.mark.parametrize("wrong", [[], {}])
@pytest.mark.defect(
    "S781", before='figure = [] or column = []: a traceback, "unhashable type"', after="refused, by its key"
)
def test_a_list_for_a_name_is_refused(
    read: Callable[[str, Path], None], text: str, path: tuple[str, ...], wrong: Any, folder: Path
) -> None:
    with pytest.raises(ModelError) as refused:
        read(written(changed(tomllib.loads(text), path, wrong)), folder)
    (problem,) = refused.value.problems
    assert problem.key.endswith(("figure", "column"))
    assert problem.got == str(wrong)
    assert problem.hint
