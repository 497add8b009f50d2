"""Named values in studies: every parameter follows them in every run, in both engines, to the bit."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.graphs.studies.study_writer import write_study
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.draws.drawing import drawn_together, on_arrays
from proofmass.runner.studies.whole.study import replay, run_study

TEXT = """\
name = "a gain of two parts"
rate = "1 kHz"
samples = 4
wires = ["source.output -> first.input", "first.output -> second.input", "second.output -> part.input"]

[measures]
last = { signal = "part.output", statistic = "last" }

[values]
half = "50 %"
angle = "30 deg"
slope = "= sqrt(half) * exp(angle) + half^2"
level = "3 V"
bits = 12

[blocks]
source = { kind = "Constant", value = "= level", unit = "V" }
first = { kind = "Gain", gain = "= slope", input_unit = "V", output_unit = "V" }
second = { kind = "Gain", gain = "= 2 * half / cos(angle)", input_unit = "V", output_unit = "V" }
part.blocks.gain = { kind = "Gain", gain = "= factor", input_unit = "V", output_unit = "V" }
part.values = { factor = 1 }
part.exports = { input = "gain.input", output = "gain.output" }
adc = { kind = "AnalogToDigital", bits = "= bits" }

[formulas]
"part.factor" = "= 1 + half / 100"
"""
GRAPH: Graph = read_graph_text(TEXT.replace("adc =", "#"))
AGES = {"ages": ["0 h", "1 year", "2 year"]}
TABLES: dict[str, dict[str, Any]] = {
    "spread": {
        "spread": {"half": {"normal": "1 %", "relative": True}, "angle": {"uniform": "5 deg"}},
    },
    "correlated": {
        "spread": {"half": {"normal": "1 %", "relative": True}, "level": {"normal": "1 %", "relative": True}},
        "correlation": {"half": {"level": -0.8}},
    },
    "swept": {"sweep": {"half": [0.4, 0.5, 0.6], "level": ["1 V", "2 V"]}},
    "drifting, and a parameter that is spread about what it follows": {
        "spread": {"first.gain": {"normal": "2 %", "relative": True}, "angle": {"uniform": "1 deg"}},
        "drift": {"half": {"ramp": "1 %/year", "relative": True}, "first.gain": {"ramp": "0.1 1/year"}},
        "epochs": AGES,
    },
    "a value that follows from another is spread itself": {
        "spread": {"slope": {"uniform": 0.1}, "half": {"values": [0.25, 0.5]}, "part.factor": {"lognormal": 0.1}},
    },
}


def by_hand(half: float, angle: float) -> tuple[float, float, float]:
    return (
        math.sqrt(half) * math.exp(angle) + half * half,
        2 * half / math.cos(angle),
        1 + half / 100,
    )


@pytest.mark.parametrize("tables", TABLES.values(), ids=TABLES)
def test_lanes_and_single_runs_agree_to_the_bit(tables: dict[str, Any]) -> None:
    study = Study(GRAPH, runs=6, seed=3, **tables)
    compiled, plain = (run_study(study, engine=engine) for engine in ("compiled", "python"))
    assert compiled.digest == plain.digest
    numbers = np.arange(study.runs * study.points)
    together = study.settings(drawn_together(study, numbers), on_arrays)
    for run in numbers.tolist():
        for epoch, drawn in enumerate(study.drawn(run)):
            alone = study.settings(drawn)
            assert {n: float(v[epoch, run]).hex() for n, v in together.items()} == {
                n: v.hex() for n, v in alone.items()
            }
            assert replay(study, run, epoch).measures["last"].value == plain["last"][run, epoch]


def test_every_parameter_follows_in_every_run() -> None:
    study = Study(GRAPH, runs=50, seed=1, **TABLES["spread"])
    result = run_study(study)
    for run in range(50):
        drawn = study.drawn(run)[0]
        assert drawn.keys() == {"half", "angle"}
        assert drawn["half"] != 0.5
        slope, second, factor = by_hand(drawn["half"], drawn["angle"])
        assert result["last"][run, 0] == pytest.approx(3.0 * slope * second * factor, rel=1e-14)
        changed = GRAPH.with_parameters(drawn)  # type: ignore[attr-defined]
        assert simulate(changed).measures["last"].value == result["last"][run, 0]


def test_what_drifts_takes_its_followers_along() -> None:
    study = Study(GRAPH, runs=3, **TABLES["drifting, and a parameter that is spread about what it follows"])
    for run in range(3):
        new, *aged = study.drawn(run)
        for epoch, at in enumerate(aged, start=1):
            assert at["half"] == pytest.approx(0.5 * (1 + 0.01 * epoch))
            base, start = by_hand(at["half"], at["angle"])[0], by_hand(new["half"], new["angle"])[0]
            assert (at["first.gain"] - 0.1 * epoch) / base == pytest.approx(new["first.gain"] / start)


def test_calibrations_may_leave_a_value() -> None:
    text = (
        TEXT.replace("adc =", "#")
        + """
[study]
runs = 2
epochs = { ages = ["0 h", "1 year"] }
recalibration = { every = "never", carried = { level = "last" } }
drift = { angle = { ramp = "1 deg/year" } }
"""
    )
    study = read_study_text(text)
    last = run_study(study)["last"]
    slope, second, factor = by_hand(0.5, math.radians(31))
    assert last[0, 1] == pytest.approx(last[0, 0] * slope * second * factor, rel=1e-14)
    assert run_study(study, engine="python")["last"].tolist() == last.tolist()


def test_a_study_reads_back() -> None:
    study = Study(GRAPH, runs=4, **TABLES["correlated"])
    again = read_study_text(write_study(study))
    assert again.text() == study.text()
    assert again.drawn(2) == study.drawn(2)


@pytest.mark.parametrize(
    ("text", "spread", "message", "hint"),
    [
        (TEXT, {"bits": {"uniform": 1}}, "adc.bits follows from it, and is an integer", "sweep it"),
        (TEXT, {"haf": {"uniform": 0.1}}, "there is no such value", "did you mean half?"),
        (TEXT, {"half": {"uniform": "1 V"}}, "V is m^2*kg/s^3/A, not 1", "give it in 1"),
        (TEXT.replace('"1 kHz"', '"= 1 kHz * half"'), {"half": {"uniform": 0.1}}, "rate follows from it", "durations"),
        (
            TEXT.replace("half = ", "idle = 3\nhalf = "),
            {"idle": {"uniform": 1}},
            "nothing follows from the value",
            "= idle",
        ),
        (
            TEXT.replace(
                'wires = ["', 'wires = ["source.output -> drive.input", "drive.output -> second.gain", "'
            ).replace("adc =", 'drive = { kind = "Gain", input_unit = "V" }\nadc ='),
            {"angle": {"uniform": "1 deg"}},
            "second.gain follows from it, and is driven by drive.output",
            "vary drive",
        ),
    ],
)
def test_what_cannot_vary(text: str, spread: dict[str, Any], message: str, hint: str) -> None:
    text = text.replace(
        '"source.output -> first.input"', '"source.output -> adc.voltage", "source.output -> first.input"'
    )
    with pytest.raises(ModelError) as error:
        Study(read_graph_text(text), spread=spread)
    (problem,) = error.value.problems
    assert message in problem.message
    assert hint in problem.hint
