"""Budgets of every noisy graph of the library within three standard errors of the mean square of 1,000 runs.

What wanders is compared by its increments, and what has one value a run by `deviation_over_runs`: the rows are those of
`python -m benchmarks.noise_budgets`. Roundings that noise does not move are alike in all runs; budgets note them.
Samples are in `test_spectra_of_runs` and `test_over_runs`.
"""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.noise_budgets import Compared, compared
from benchmarks.noise_comparison import noisy_graphs
from proofmass import noise, read_graph, simulate
from proofmass.graphs.model.build import read_probe
from tests.by_hand.graph_texts import ALONE

LITTLE = 1e-3  # part of a mean square that roundings which noise does not move may have
LEFT_OUT = {
    ("chamber_accelerometer", "deviation.output"): "its average has one value in four hours, as long as the run",
    ("mems_microphone", "converter.state"): "runs that begin alike decide alike for 50,000 ticks",
    ("sigma_delta_accelerometer", "second.output"): "runs that begin alike stay alike for 0.13 s",
    ("quartz_calibration_disturbed", "sensor.accelerometer.adc.number"): "its budget is about the end of a long run",
}


def counts(graph: str, line: Compared) -> bool:
    """Return whether runs say anything of a budget."""
    if (graph, line.output) in LEFT_OUT or line.errors is None:
        return False
    return line.row is None or sum(source.share for source in line.row.budget.sources if source.doubtful) < LITTLE


@pytest.mark.exhaustive
@pytest.mark.parametrize("path", ALONE, ids=lambda path: path.stem)
def test_mean_squares_of_many_runs(path: Path) -> None:
    for _, _, outputs in noisy_graphs([path.stem]):
        lines = [line for line in compared(path, outputs) if counts(path.stem, line)]
        assert {line.output: line.errors for line in lines if not line.rms_holds} == {}


@pytest.mark.exhaustive
def test_the_library_has_what_is_left_out() -> None:
    for graph, output in LEFT_OUT:
        assert [output in outputs for _, _, outputs in noisy_graphs([graph])] == [True]


@pytest.mark.exhaustive
def test_the_end_of_a_long_run_has_the_noise_of_its_budget() -> None:
    """Of 97 s the budget has the last quarter of a second; twelve runs have that noise there, and less at the start."""
    graph, output = read_graph("library:quartz_calibration_disturbed"), "sensor.accelerometer.adc.number"
    probed = graph.changed(probes=(read_probe(output),))
    runs = [simulate(probed, seed=seed)[output].values[-12_000:].astype(float) for seed in range(1, 13)]
    squares = [np.mean((one - other) ** 2) / 2.0 for one, other in zip(runs[::2], runs[1::2], strict=True)]
    error = np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert noise(graph, output).rms ** 2 == pytest.approx(np.mean(squares), abs=3.0 * error)
