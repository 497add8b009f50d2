"""Noise, responses, worst cases and yields as requirements and goals, against closed forms of an integrating loop.

L = K T / (z - 1) / z and the response from wanted to plant is L / (1 + L); the settled plant is at the wanted value.
"""

import math
import tomllib

import numpy as np
import pytest

from proofmass import Graph
from proofmass.blocks import Constant
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.design.tune.tune import tune
from proofmass.runner.design.worst.worst import worst
from proofmass.runner.verification.verify import Finding, Measurements, verify
from tests.by_hand.design_texts import INTEGRATING
from tests.by_hand.graph_schema import VALIDATOR

REQUIREMENTS = """
[requirements]
quiet = { quantity = { noise = "plant.output" }, at_most = 0.0058, at_least = 0.0056 }
in_band = { quantity = { noise = "plant.output", band = [0, "10 Hz"] }, at_most = 1 }
gain = { quantity = { response = "plant.output", input = "IN", frequency = "10 Hz" }, at_least = 0.5 }
turn = { at_most = 0, quantity = { response = "plant.output", input = "IN", frequency = 10, figure = "phase" } }
fast = { quantity = { response = "plant.output", input = "IN", figure = "rise_time" }, at_most = "25 ms" }
calm = { quantity = { response = "plant.output", input = "IN", figure = "overshoot" }, at_most = "1 %" }
exact = { quantity = { scale_factor = "plant.output", input = "IN" }, at_least = 0.999999, at_most = 1.000001 }
double = { quantity = { measure = "twice" }, at_least = 1.99 }
good = { quantity = { yield = "end" }, at_least = "30 %" }
phase = { quantity = "main.phase_margin", at_least = "70 deg", tolerances = { "plant.gain" = "10 %" } }
worst_end = { quantity = "twice", at_least = 1.8, tolerances = "spread" }
lot = { quantity = { yield = true }, at_least = "0 %", tolerances = { "plant.gain" = "10 %" } }

[study]
runs = 64
spread = { "wanted.amplitude" = { uniform = 0.1 } }
limits = { end = { at_least = 1.0 } }
""".replace("IN", "wanted.output")
TEXT = INTEGRATING.replace("[blocks.hiss]", "[blocks.hiss]  # noise", 1).replace("density", "density", 1)
TEXT = TEXT.replace("top = { signal", 'twice = "= 2 * end"\ntop = { signal') + REQUIREMENTS
QUIET = TEXT.replace("1e-3 1/sqrt(Hz)", "1e-9 1/sqrt(Hz)")
T, K = 1e-3, 100.0


def closed(z: complex | np.ndarray, gain: float = K) -> np.ndarray:
    """T(z) = L / (1 + L)."""
    loop = gain * T / (z - 1.0) / z
    return np.asarray(loop / (1.0 + loop))


@pytest.fixture(scope="module")
def findings() -> dict[str, Finding]:
    loud, quiet = (read_study_text(text) for text in (TEXT, QUIET))
    of_noise = {"quiet", "in_band"}
    found = {f.id: f for f in verify(Measurements(quiet.graph, quiet, "python")) if f.id not in of_noise}
    few = loud.graph.changed(requirements={n: r for n, r in loud.graph.requirements.items() if n in of_noise})
    return found | {f.id: f for f in verify(Measurements(few, None, "python"))}


@pytest.mark.exhaustive
def test_noise_and_responses(findings: dict[str, Finding]) -> None:
    turns = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 1 << 16, endpoint=False) + 1e-12j)
    rms = math.sqrt(0.5 * 1e-6 / T * float(np.mean(np.abs(closed(turns)) ** 2)))
    assert findings["quiet"].value == pytest.approx(rms, rel=1e-4)
    low = np.exp(2j * np.pi * np.linspace(1e-3, 10.0, 4001) * T)
    in_band = math.sqrt(1e-6 * float(np.trapezoid(np.abs(closed(low)) ** 2, dx=10.0 / 4000)))
    assert findings["in_band"].value == pytest.approx(in_band, rel=1e-3)
    at_ten = complex(closed(np.exp(2j * np.pi * 10.0 * T)))
    assert findings["gain"].value == pytest.approx(abs(at_ten), rel=1e-9)
    assert findings["turn"].value == pytest.approx(math.degrees(np.angle(at_ten)), rel=1e-9)
    assert findings["fast"].value == pytest.approx(math.log(9.0) / K, rel=0.2), "about that of a lag of 1 / K"
    assert findings["exact"].value == pytest.approx(1.0, abs=1e-9)
    assert findings["gain"].quantity == "gain from wanted.output to plant.output at 10 Hz"


@pytest.mark.exhaustive
def test_worst_cases_and_yields(findings: dict[str, Finding]) -> None:
    crossover = 2.0 * math.asin(0.5 * 1.1 * K * T) / T
    assert findings["phase"].value == pytest.approx(90.0 - 1.5 * math.degrees(crossover * T), rel=1e-9)
    assert findings["phase"].quantity == "main.phase_margin, worst case"
    assert findings["worst_end"].value == pytest.approx(2.0 * 0.9, rel=1e-5), "the lowest end of the spread"
    study = read_study_text(QUIET)
    settled = sum(study.drawn(run)[0]["wanted.amplitude"] >= 1.0 for run in range(64)) / 64
    assert findings["good"].value == pytest.approx(settled, abs=1 / 64)
    assert findings["lot"].value <= findings["good"].value
    assert findings["double"].value == pytest.approx(2.0, rel=1e-6)


@pytest.mark.exhaustive
def test_a_yield_is_a_goal_and_has_a_worst_case() -> None:
    """Amplitudes are 0.1 around their mean: all sensors end above 1 from 1.1 on."""
    study = read_study_text(QUIET)
    goals = {"good": {"yield": True, "at_least": "99 %"}, "low": {"measure": "twice", "minimise": True}}
    free = {"wanted.amplitude": {"at_least": 1.0, "at_most": 1.6}}
    tuned = tune(study.graph, free=free, goals=goals, study=study, samples=16, starts=1)
    assert tuned.met
    assert 1.085 < tuned.parameters["wanted.amplitude"] < 1.14
    spread = worst(study, {"y": {"yield": "end"}}, tolerances={"wanted.amplitude": 0.2}, samples=2)
    assert spread.cases[0].worst == 0.0
    with pytest.raises(ModelError, match="a yield is wanted, and there is no study with limits"):
        tune(study.graph, free=free, goals=goals)
    with pytest.raises(ModelError, match="the study has no such limit"):
        worst(study, {"y": {"yield": "top"}}, tolerances={"wanted.amplitude": 0.2})


VARIED = 'tolerances = { "plant.gain" = "10 %" }, proved = true }'
PROVED = f"""
[requirements]
always = {{ quantity = "main.stable", at_least = "stable", {VARIED}
gain = {{ quantity = "main.gain_margin", at_least = "19.1 dB", {VARIED}
more = {{ quantity = {{ loop = "main", figure = "gain_margin" }}, at_least = "19.5 dB", {VARIED}
phase = {{ quantity = "main.phase_margin", at_least = "80 deg", {VARIED}
spread = {{ quantity = "main.phase_margin", at_least = "80 deg", tolerances = "spread", proved = true }}
delay = {{ quantity = "main.delay_margin", at_least = "10 ms", {VARIED}
later = {{ quantity = "main.delay_margin", at_least = "20 ms", {VARIED}
disk = {{ quantity = {{ loop = "main", figure = "disk_margin" }}, at_least = 1.2, {VARIED}

[study]
spread = {{ "plant.gain" = {{ uniform = "10 %", relative = true }} }}
"""


def test_noise_that_is_proved() -> None:
    """The plant is z / (z^2 - z + a) a / z of the noise: its variance is a (1 + a) / ((1 - a) (2 + a)) of that."""
    a, variance = 1.1 * K * T, 1e-6 * 0.5 / T
    worst = math.sqrt(variance * a * (1.0 + a) / ((1.0 - a) * (2.0 + a)))
    text = (
        INTEGRATING
        + f"""
[requirements]
calm = {{ quantity = {{ noise = "plant.output" }}, at_most = {1.02 * worst}, {VARIED}
loud = {{ quantity = {{ noise = "plant.output" }}, at_most = {0.98 * worst}, {VARIED}
"""
    )
    found = {f.id: f for f in verify(Measurements(read_graph_text(text), None)) if f.id in ("calm", "loud")}
    assert [finding.met for finding in found.values()] == [True, False]
    assert found["calm"].quantity == "noise of plant.output, proved"
    assert 0.98 * worst < found["loud"].value < 1.001 * worst


@pytest.mark.exhaustive
def test_peaks_that_are_proved() -> None:
    """From what is wanted to the plant the gain is a / (z^2 - z + a), with real poles: at most that at rest, 1."""
    of = '{ quantity = { response = "plant.output", input = "wanted.output", figure = "peak" }'
    text = (
        INTEGRATING
        + f"\n[requirements]\nlow = {of}, at_most = 1.001, {VARIED}\nhigh = {of}, at_most = 0.99, {VARIED}\n"
    )
    found = {f.id: f for f in verify(Measurements(read_graph_text(text), None)) if f.id in ("low", "high")}
    assert (found["low"].met, found["high"].met) == (True, False)
    assert found["high"].value == pytest.approx(1.0)
    assert found["low"].quantity == "peak from wanted.output to plant.output, proved"


def test_scale_factors_that_are_proved() -> None:
    """The plant settles to what is wanted, whatever its gain."""
    of = '{ quantity = { scale_factor = "plant.output", input = "wanted.output" }'
    lines = [
        f"{name} = {of}, {limits}, {VARIED}"
        for name, limits in (
            ("both", "at_least = 0.999, at_most = 1.001"),
            ("one", 'at_most = "1.001"'),
            ("wrong", "at_least = 1.001, at_most = 2"),
        )
    ]
    text = INTEGRATING + "\n[requirements]\n" + "\n".join(lines)
    graph = read_graph_text(text)
    found = {f.id: f for f in verify(Measurements(graph, None)) if f.id in ("both", "one", "wrong")}
    assert [finding.met for finding in found.values()] == [True, True, False]
    assert found["both"].quantity == "scale factor from wanted.output to plant.output, proved"
    assert (found["both"].value, found["one"].value) == (0.999, 1.001)
    assert found["wrong"].value == pytest.approx(1.0)
    assert "a sensor within the tolerances has scale factor 1" in found["wrong"].reason
    assert VALIDATOR.is_valid(tomllib.loads(text))


def test_biases_that_are_proved() -> None:
    """While nothing is wanted the plant rests at zero, whatever its gain."""
    of = '{ quantity = { bias = "plant.output", input = "wanted.output" }'
    lines = [f"near = {of}, at_least = -1e-6, at_most = 1e-6, {VARIED}", f"far = {of}, at_least = 0.1, {VARIED}"]
    text = INTEGRATING + "\n[requirements]\n" + "\n".join(lines)
    found = {f.id: f for f in verify(Measurements(read_graph_text(text), None)) if f.id in ("near", "far")}
    assert (found["near"].met, found["far"].met) == (True, False)
    assert found["near"].quantity == "bias from wanted.output to plant.output, proved"
    assert found["far"].value == pytest.approx(0.0, abs=1e-9)


@pytest.mark.exhaustive
def test_margins_that_are_proved() -> None:
    """z^2 - z + K T is stable up to K T = 1: 10 % more gain leave a factor of 1 / 0.11, 19.17 dB."""
    study = read_study_text(INTEGRATING + PROVED)
    found = {f.id: f for f in verify(Measurements(study.graph, study, "python"))}
    assert [name for name, finding in found.items() if not finding.met] == ["later", "more"]
    assert found["always"].quantity == "main.stable, proved"
    assert found["gain"].value == 19.1
    assert found["later"].value < 0.02
    assert (found["delay"].quantity, found["disk"].value) == ("main.delay_margin, proved", 1.2)
    more, least = found["more"], 20.0 * math.log10(1.0 / (1.1 * K * T))
    assert least <= more.value < 19.5
    assert more.reason.startswith("a sensor within the tolerances has 19.")
    assert "plant.gain = " in more.reason
    assert read_graph_text(write_graph(study.graph)).requirements == study.graph.requirements
    assert VALIDATOR.is_valid(tomllib.loads(INTEGRATING + PROVED))


def test_they_read_back_and_the_schema_knows_them() -> None:
    graph = read_graph_text(TEXT)
    assert not check(graph)
    assert read_graph_text(write_graph(graph)) == graph
    assert VALIDATOR.is_valid(tomllib.loads(TEXT))


def test_both_limits_may_be_one_value() -> None:
    text = '\n[requirements]\nexact = { quantity = "end", at_least = 1.5, at_most = 1.5 }\n'
    assert not check(read_graph_text(INTEGRATING + text))


@pytest.mark.parametrize(
    ("line", "message", "key"),
    [
        ('{ quantity = { noise = "plant.out" }, at_most = 1 }', "plant.out is not an output", "quantity.noise"),
        ('{ quantity = { nose = "plant.output" }, at_most = 1 }', "unknown key", "quantity.nose"),
        ('{ quantity = { noise = "plant.output" }, at_most = "1 V" }', "V is", "at_most"),
        ('{ quantity = { response = "plant.output" }, at_most = 1 }', "response needs an input", "quantity"),
        ("{ quantity = { yield = 3 }, at_most = 1 }", "is not a limit", "quantity.yield"),
        ('{ quantity = "end", at_most = 1, tolerances = "wide" }', "must be a table of tolerances", "tolerances"),
        ('{ quantity = "main.stable", at_least = 1, tolerances = "spread" }', "a verdict has no worst", "tolerances"),
        ('{ quantity = "yield", at_least = 1, tolerances = "spread" }', "the spread is in the yield", "tolerances"),
        ('{ quantity = "main.phase_margin", at_least = 1, proved = true }', "nothing to be proved over", "proved"),
        ('{ quantity = "main.phase_margin", at_least = 1, proved = "yes" }', "must be true or false", "proved"),
        (f'{{ quantity = "main.phase_margin", at_most = 1, {VARIED}', "must be at_least alone", "proved"),
        (f'{{ quantity = {{ noise = "plant.output" }}, at_least = 1, {VARIED}', "must be at_most alone", "proved"),
        (f'{{ quantity = "main.sensitivity_peak", at_least = 1, {VARIED}', "has no proof", "quantity"),
        (f'{{ quantity = "main.stable", at_least = 1, at = "0.1 s", {VARIED}', "must be the start or settled", "at"),
    ],
)
def test_mistakes_have_their_line(line: str, message: str, key: str) -> None:
    text = INTEGRATING + f"\n[requirements]\nodd = {line}\n"
    try:
        (problem,) = check(read_graph_text(text, "graph.toml"))
    except ModelError as error:
        (problem,) = error.problems
    assert message in problem.message
    assert problem.key == f"requirements.odd.{key}"
    assert problem.line == text.count("\n")


@pytest.mark.defect("S919", before="the highest value of a window, whatever its limits", after="that next to a limit")
@pytest.mark.parametrize(
    ("low", "high", "shown"), [(0.89, 2.0, 0.9), (0.0, 1.11, 1.1), (0.95, 2.0, 0.9), (0.0, 1.05, 1.1)]
)
def test_the_worst_case_of_a_window_is_next_to_its_limit(low: float, high: float, shown: float) -> None:
    """A constant of 1 within 10 %."""
    within = {"quantity": "m", "at_least": low, "at_most": high, "tolerances": {"a.value": "10 %"}}
    graph = Graph(
        name="a constant",
        rate="1 kHz",
        samples=1,
        blocks={"a": Constant(value=1.0)},
        measures={"m": {"signal": "a.output", "statistic": "last"}},
        requirements={"R": within},
    )
    (finding,) = verify(Measurements(graph, None))
    assert finding.value == pytest.approx(shown)
    assert finding.met is (low <= shown <= high)
