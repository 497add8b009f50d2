"""Disk margins of several loops at once: a published example, dense sweeps by SLICOT, and the graph's own poles."""

import math

import control
import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.several.over import margins_over, margins_over_age
from proofmass.runner.analysis.several.plot import plot_over, plot_together
from proofmass.runner.analysis.several.together import Together, _golden, margins_together, of_system
from proofmass.runner.host.arrays import Array
from tests.by_hand.design_texts import COUPLED, INTEGRATING

slycot = pytest.importorskip("slycot")
GRAPH = read_graph_text(COUPLED)
X, Y, X_CROSS, Y_CROSS = 0.2, 0.12, 0.6, -0.9  # gains of a tick


def system_of(a: Array, b: Array, c: Array, d: Array, period: float) -> OpenLoop:
    """An open loop of these matrices, with the sign of negative feedback."""
    states, wires = len(a), b.shape[1]
    matrix = np.block([[a, b, np.zeros((states, 1))], [-c, -d, np.zeros((wires, 1))]])
    ends = tuple((f"wire_{i}", "output", 0) for i in range(wires))
    entries = tuple((f"state_{i}", "x", -1) for i in range(states))
    return OpenLoop(PeriodMap(entries, ends, ends, matrix, {}, period))


@pytest.mark.exhaustive
def test_the_spinning_satellite() -> None:
    """Doyle's example: each loop alone has any gain and 90 deg, both at once next to nothing (Zhou, 1996, section 9.6).

    diskmargin of the Robust Control Toolbox gives 0.0997 for both at once. Tustin's rule maps the axis on the circle.
    """
    plant = control.ss([[0.0, 10.0], [-10.0, 0.0]], np.eye(2), [[1.0, 10.0], [-10.0, 1.0]], np.zeros((2, 2)))
    sampled = control.sample_system(plant, 0.01, method="bilinear")
    found = of_system(system_of(sampled.A, sampled.B, sampled.C, sampled.D, 0.01), ["x", "y"], [1, 1])
    assert found.margin == pytest.approx(0.0997, abs=1e-4)
    w = np.linspace(0.04, 0.06, 20_001)
    exact = 1.0 / np.max(np.abs((1j * w - 1.0) / 2.0 + 10j) / np.abs(1.0 + 1j * w))
    assert found.margin == pytest.approx(exact, rel=1e-6)
    assert found.alone == pytest.approx((2.0, 2.0), rel=1e-6)
    assert found.gain == pytest.approx(1.105, abs=1e-3)


def loop(z: complex) -> np.ndarray:  # type: ignore[type-arg]
    """L of COUPLED, by hand: gain and delay of each loop, two integrators, and what crosses over."""
    through = np.diag([X, Y]) / z
    return through @ np.array([[1.0, X_CROSS], [Y_CROSS, 1.0]]) / (z - 1.0)


@pytest.mark.exhaustive
def test_two_loops_of_a_graph_against_a_dense_sweep_by_slicot() -> None:
    found = margins_together(GRAPH)
    angles = np.concatenate([np.geomspace(1e-4, 0.05, 60), np.linspace(0.05, math.pi, 600)])
    largest, alone = 0.0, np.zeros(2)
    for angle in angles:
        disk = np.linalg.inv(np.eye(2) + loop(np.exp(1j * angle))) - 0.5 * np.eye(2)
        largest = max(largest, slycot.ab13md(disk, [1, 1], [2, 2])[0])
        alone = np.maximum(alone, np.abs(np.diag(disk)))
    assert found.margin is not None
    assert found.margin <= 1.0 / largest * (1.0 + 1e-9), "the sweep misses the peak by a little"
    assert found.margin == pytest.approx(1.0 / largest, rel=1e-4)
    assert found.alone == pytest.approx(1.0 / alone, rel=1e-4)
    for name, value in zip(found.loops, found.alone, strict=True):
        assert value == pytest.approx(margins(GRAPH, name).disk_margin, rel=1e-6)
    assert found.unstructured is not None
    assert found.unstructured <= found.margin
    dense = np.linspace(0.01, math.pi, 4000)
    matrices = np.array([np.linalg.inv(np.eye(2) + loop(np.exp(1j * angle))) for angle in dense])
    assert found.sensitivities == pytest.approx(np.max(np.abs(matrices), axis=0), rel=1e-5)
    assert found.complementary == pytest.approx(np.max(np.abs(np.eye(2) - matrices), axis=0), rel=1e-3)


def test_what_goes_one_way_between_loops_moves_no_margin_at_any_frequency() -> None:
    """Both loops are x / (z - 1) with a delay; however strong the way from the one to the other, each counts alone."""
    a, b, c = np.array([[1.0, 0.0], [1e6, 1.0]]), np.diag([0.3, 0.4]), np.eye(2)
    found = of_system(system_of(a, b, c, np.zeros((2, 2)), 1.0), ["x", "y"], [1, 1])
    assert 1.0 / found.bounds == pytest.approx(np.min(1.0 / found.of_each, axis=0), rel=1e-4)
    assert found.margin == pytest.approx(min(found.alone), rel=1e-6)


def test_a_picture_begins_a_decade_before_the_first_change() -> None:
    """A pole at 1 - 1e-6 that hardly counts makes the sweep begin far below; half the rate is 500 Hz."""
    a, b = np.diag([1.0, 1.0, 1.0 - 1e-6]), np.array([[0.3, 0.0], [0.0, 0.4], [1e-3, 0.0]])
    c = np.array([[1.0, 0.0, 1e-6], [0.0, 1.0, 0.0]])
    found = of_system(system_of(a, b, c, np.zeros((2, 2)), 1e-3), ["x", "y"], [1, 1])
    first, last = plot_together(found).axes[0].get_xlim()
    moved = np.abs(found.of_each / found.of_each[:, :1] - 1.0).max(axis=0) > 1e-3
    assert first == pytest.approx(found.frequencies[moved][0] / 10.0, rel=0.05)
    assert last == pytest.approx(500.0)


@pytest.mark.exhaustive
def test_its_factors_put_a_pole_on_the_circle_and_smaller_ones_do_not() -> None:
    found = margins_together(GRAPH)
    assert found.reached == pytest.approx(found.margin, rel=1e-6)
    z = np.exp(2j * math.pi * (found.frequency or 0.0) * 1e-3)
    closed = np.eye(2) + loop(z) @ np.diag(found.factors)
    assert abs(np.linalg.det(closed)) < 1e-5
    rng, margin = np.random.default_rng(1), found.margin or 0.0
    for _ in range(20):
        deltas = 0.999 * margin * np.exp(2j * math.pi * rng.random(2))
        factors = (1.0 + deltas / 2.0) / (1.0 - deltas / 2.0)
        roots = closed_poles(np.diag(factors))
        assert np.max(np.abs(roots)) < 1.0


def closed_poles(factors: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """Poles of z (z - 1) I + F G = 0, by a companion matrix."""
    gains = factors @ np.diag([X, Y]) @ np.array([[1.0, X_CROSS], [Y_CROSS, 1.0]])
    companion = np.block([[np.zeros((2, 2)), np.eye(2)], [-gains, np.eye(2)]])
    return np.linalg.eigvals(companion)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "seed", [59, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(100) if seed != 59)]
)
@pytest.mark.defect(
    "S91",
    before="a margin 0.16 % too large, its peak not that of a quick bound; 4 times, its peak at half the rate",
    after="less",
)
def test_random_systems_of_two_and_three_loops(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wires = 2 + seed % 2
    while True:
        sizes = int(rng.integers(2, 6)), wires
        a = rng.standard_normal((sizes[0], sizes[0]))
        a *= 0.95 / np.max(np.abs(np.linalg.eigvals(a)))
        b, c = rng.standard_normal(sizes), rng.standard_normal(sizes[::-1]) * 0.3
        system = system_of(a, b, c, np.zeros((wires, wires)), 1e-3)
        if np.max(np.abs(np.linalg.eigvals(a - b @ c))) < 0.98:
            break
    found = of_system(system, [f"loop {i}" for i in range(wires)], [1] * wires)
    largest = 0.0
    for angle in np.linspace(0.0, math.pi, 1500):
        response = c @ np.linalg.solve(np.exp(1j * angle) * np.eye(len(a)) - a, b.astype(complex))
        disk = np.linalg.inv(np.eye(wires) + response) - 0.5 * np.eye(wires)
        largest = max(largest, slycot.ab13md(disk, [1] * wires, [2] * wires)[0])
    assert found.margin is not None
    assert found.margin <= 1.0 / largest * (1.0 + 1e-6)
    assert found.margin == pytest.approx(1.0 / largest, rel=1e-3)


@pytest.mark.exhaustive
def test_pictures_and_refusals() -> None:
    found = margins_together(GRAPH, ["x", "y"])
    (panel,) = plot_together(found).axes
    assert "disk margin" in panel.get_title(loc="left")
    curves = [np.asarray(line.get_xydata()).T for line in panel.lines if len(line.get_xdata()) > 1]
    changes = min(f[np.abs(margin / margin[0] - 1.0) > 1e-3][0] for f, margin in curves)
    assert panel.get_xlim()[0] == pytest.approx(max(changes / 10.0, curves[0][0][0]), rel=0.1)
    with pytest.raises(ModelError, match="several loops"):
        margins_together(read_graph_text(INTEGRATING))
    with pytest.raises(ModelError, match="same output"):
        margins_together(GRAPH, ["x", "x_gain.output"])
    wild = margins_together(GRAPH.with_parameters({"x_gain.gain": 1500.0}))
    assert isinstance(wild, Together)
    assert wild.margin is None
    assert wild.verdict == "unstable"


def test_margins_over_a_parameter_and_over_age() -> None:
    graph = read_graph_text(INTEGRATING)
    over = margins_over(graph, "controller.gain", [100.0, 300.0, 1200.0])
    phases = [row["main"].phase_margin for row in over.margins]
    known = [math.radians(90.0) - 3.0 * math.asin(gain * 0.5e-3) for gain in (100.0, 300.0)]
    assert phases[:2] == pytest.approx(known, rel=1e-9)
    assert not over.margins[2]["main"].stable
    assert "not stable" in plot_over(over).axes[0].get_title(loc="left")
    text = '\n[study]\nmargins = "0 s"\nepochs = { ages = ["0 h", "10 year"] }\n'
    drift = '[study.drift]\n"controller.gain" = { ramp = "2 %/year", ramp_spread = "1 %/year", relative = true }\n'
    aged = margins_over_age(read_study_text(INTEGRATING + text + drift))
    assert aged.margins[1]["main"].phase_margin == pytest.approx(math.radians(90.0) - 3.0 * math.asin(0.06), rel=1e-6)
    with pytest.raises(ModelError, match="nothing drifts"):
        margins_over_age(read_study_text(INTEGRATING + text))


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6])
def test_a_peak_is_found_to_a_part_of_its_frequency(scale: float) -> None:
    """The golden section: n steps from [1, 2] to 10^-5 of the end, 0.618^n < 1.4 10^-5, of one value each."""
    asked: list[float] = []

    def height(w: float) -> float:
        asked.append(w)
        return 3.0 - (w / scale - 1.4) ** 2

    w, value = _golden(height, scale, 2.0 * scale, (1.5 * scale, 2.99))
    assert w == pytest.approx(1.4 * scale, rel=1e-5)
    assert value == pytest.approx(3.0, abs=1e-9)
    assert all(scale < place < 2.0 * scale for place in asked)
    assert len(asked) == 2 + math.ceil(math.log(1.4e-5) / math.log(0.5 * (math.sqrt(5.0) - 1.0)))
    assert _golden(lambda w: -w, 1.0, 2.0, (1.0, -1.0)) == (1.0, -1.0), "the best place that is known stays"
