"""The loop that a page carries computes the bits of the command line, whatever its parameters are."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.formulas.operations import FUNCTIONS, OPERATIONS
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.spectrum.welch import spectrum
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.live.model import live_model
from proofmass.runner.run.simulate import simulate
from tests.by_hand.graph_texts import ALONE
from tests.by_hand.live_node import run_carried
from tests.by_hand.node import needs_node

TICKS = 2100
GRAPHS = [path.name for path in ALONE]
FEW = ("vibratory_gyroscope.toml", "self_calibration_fixed.toml")  # steps of a nonlinear group; registers
WITH_VALUES = [name for name in GRAPHS if "[values]" in library_files()[name].read_text(encoding="utf-8")]
FEW_WITH_VALUES = ("force_balance_seismometer.toml", "fibre_optic_gyroscope.toml")
OF_MEASURES = """
name = "measured"
rate = "10 Hz"
samples = 41
wires = ["noise.output -> meter.voltage"]
probes = ["noise.output"]
[blocks.noise]
kind = "WhiteNoise"
density = "700 mV/sqrt(Hz)"
unit = "V"
[blocks.meter]
kind = "AnalogToDigital"
reference = "5 V"
[measures]
spread = { signal = "noise.output", statistic = "rms", unit = "mV" }
code = { signal = "meter.code", statistic = "last" }
late = { signal = "noise.output", statistic = "mean", from = "3 s" }
half = { formula = "= 1.7 * spread / 3.1 - -late", unit = "mV" }
ratio = "= 0.2 + half / spread / 4 + code / 3000"
cubed = "= ratio^-3 * spread^4 + 3 mV * (half - late)^3 / code"
fraction = "= ratio^0.7 + ratio^(1/3)"
nothing = "= 3 * pi"
"""
MARKED = [name if name in FEW else pytest.param(name, marks=pytest.mark.exhaustive) for name in GRAPHS]


def library(name: str) -> Graph:
    return read_graph(library_files()[name])


def _factor(slider: dict[str, Any]) -> float:
    """Up by a thousandth, or down where that is out of bounds."""
    highest = slider["at_most"] if slider["below"] is None else slider["below"]
    return 1.001 if highest is None or slider["value"] * 1.001 < highest else 0.999


@pytest.mark.exhaustive
@needs_node
@pytest.mark.parametrize("name", MARKED)
def test_bits_of_the_library(name: str) -> None:
    """Of each graph, as it is and with every slider moved by a thousandth."""
    path = library_files()[name]
    model = live_model(graph := read_graph(path), TICKS)
    own = [slider for slider in model["sliders"] if not slider["named"]]
    moved = {f"{s['block']}.{s['parameter']}": s["value"] * _factor(s) for s in own}
    moved = {name: value for name, value in moved.items() if value != 0.0}
    options = [option.removeprefix("--set ") for option in model["options"]]
    changed = graph_of(path, None, (*(f"{name}={value!r}" for name, value in moved.items()), *options))
    still, other = run_carried(model, {}, {"values": moved, "chunk": 37})
    assert still["digest"] == simulate(graph, samples=TICKS).digest
    assert other["digest"] == simulate(changed, samples=TICKS).digest


@pytest.mark.exhaustive
@needs_node
@pytest.mark.parametrize(
    "name", [n if n in FEW_WITH_VALUES else pytest.param(n, marks=pytest.mark.exhaustive) for n in WITH_VALUES]
)
def test_bits_of_named_values(name: str) -> None:
    """Every value that has a slider, moved by its own factor: what follows is what Python computes."""
    path = library_files()[name]
    model = live_model(read_graph(path), TICKS)
    named = [slider for slider in model["sliders"] if slider["named"]]
    assert named
    names = [".".join(filter(None, (s["block"], s["parameter"]))) for s in named]
    moved = {n: s["value"] * (1.0 + 0.0037 * (i + 1)) for i, (n, s) in enumerate(zip(names, named, strict=True))}
    options = [option.removeprefix("--set ") for option in model["options"]]
    changed = graph_of(path, None, (*(f"{n}={value!r}" for n, value in moved.items()), *options))
    (other,) = run_carried(model, {"named": moved})
    assert other["digest"] == simulate(changed, samples=TICKS).digest


LATE = """
name = "late"
samples = 16
rate = "1 kHz"
wires = ["source.output -> late.input"]
probes = ["late.output"]
[blocks.source]
kind = "Ramp"
[blocks.late]
kind = "Gain"
rate = "100 Hz"
clock_offset = "5 ms"
"""


@needs_node
@pytest.mark.defect("S929", before="rows behind a clock offset were one too many, and shifted", after="as they are")
def test_rows_of_a_late_clock_are_those_of_the_command_line() -> None:
    """Its ticks are 5, 15, ... of 1 kHz: none, one, and two of them, in pieces of any size."""
    graph = read_graph_text(LATE)
    model = live_model(graph)
    settings = [{"ticks": ticks, "chunk": chunk} for ticks in (4, 15, 16) for chunk in (3, 16)]
    digests = [answer["digest"] for answer in run_carried(model, *settings)]
    assert digests == [simulate(graph, samples=one["ticks"]).digest for one in settings]


@pytest.mark.exhaustive
@needs_node
def test_measures_given_by_formulas_are_those_of_the_command_line() -> None:
    """Every operation of formulas, of other measures, with units and in order; to the bit, while a parameter moves."""
    given = {name: ", ".join(["ratio", "1 / code"][: OPERATIONS[name].arity]) for name in FUNCTIONS}
    text = OF_MEASURES + "".join(f'of_{name} = "= {name}({arguments})"\n' for name, arguments in given.items())
    graph = read_graph_text(text)
    model = live_model(graph)
    moved = {"noise.density": 0.9}
    *answers, short = run_carried(model, {}, {"values": moved, "chunk": 3}, {"ticks": 20})
    for answer, run in zip(answers, (graph, with_parameters(graph, moved)), strict=True):
        measures = {name: measure.value for name, measure in simulate(run).measures.items()}
        assert answer["measures"] == measures
        assert all(map(math.isfinite, measures.values()))
        assert list(answer["measures"]) == list(measures)
    assert answers[0]["measures"]["of_sin"] != answers[1]["measures"]["of_sin"]
    assert answers[0]["measures"]["nothing"] == 3.0 * math.pi
    assert short["measures"]["late"] is short["measures"]["half"] is short["measures"]["of_sin"] is None
    shown = {measure["name"]: (measure["signal"], measure["unit"]) for measure in model["loop"]["measures"]}
    assert shown["half"] == ("= 1.7 * spread / 3.1 - -late", "V as mV")
    assert [scale["text"] for scale in model["units"]["V as mV"]] == ["mV"]


@needs_node
def test_spectra_are_those_of_the_command_line() -> None:
    graph = library("template.toml")
    result = simulate(graph)
    (answer,) = run_carried(live_model(graph), {}, spectrum=True)
    for name, drawn in zip(sorted(result.traces), answer["spectra"], strict=True):
        expected = spectrum(result[name])
        np.testing.assert_allclose(drawn["x"], expected.frequencies[1:], rtol=1e-12)
        largest = float(expected.amplitude_density.max())
        np.testing.assert_allclose(drawn["y"], expected.amplitude_density[1:], rtol=1e-9, atol=1e-12 * largest)


def test_probes_and_wires_say_whether_they_hold_their_values() -> None:
    data = live_model(read_graph("library:closed_loop_accelerometer"))["loop"]
    wires = {wire["name"]: wire["held"] for wire in data["wires"]}
    assert [probe["held"] for probe in data["probes"]] == [True]
    assert not wires["pendulum.angle"], "a state of a continuous block moves between ticks"
    assert wires["pid.output"]
    assert wires["dac.code"]
