"""Noise budgets of the library beside the spectra of their own runs.

python benchmarks/noise_budgets.py [NAME]

The noise of a run is what two runs of different seeds differ by, over sqrt(2): signals drop out. Each row is an output,
its rms by the budget and by these runs, how many lines of the Welch spectrum lie in the band that holds 99 % of them,
and by how many standard errors the last values of 1,000 runs in lanes scatter more than predicted, which should be 3
at most. Of an output that wanders, whose rms grows with time, that column is empty.
"""

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

import proofmass
from proofmass import Graph, NoiseBudget, Series, Spectrum
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.measures import Measure

LIBRARY = Path(__file__).parents[1] / "graphs" / "library"
_LINES = slice(3, -2)  # the window leaks into those beside zero and half the rate
VALUES, SEGMENT, CONFIDENCE = 40_000, 256, 0.99
RUNS, LAST_VALUE = 1000, 3000


@dataclass(frozen=True)
class Case:
    """An output of a graph of the library, and how its spectrum is taken."""

    file: str
    output: str
    values: int = VALUES
    segment: int = SEGMENT


CASES = (
    Case("accelerometer/recorded_motion.toml", "mean.mean"),
    Case("accelerometer/recorded_motion.toml", "adc.number"),
    Case("quartz/quartz_feedback_noise.toml", "force.output"),
    Case("quartz/quartz_feedback_noise.toml", "output.output"),
    Case("quartz/quartz_calibration_disturbed.toml", "force.output", 120_000, 8192),
    Case("temperature/temperature_compensation_m1.toml", "noisy.output"),
    Case("temperature/temperature_compensation_m2.toml", "noisy.output"),
    Case("temperature/temperature_compensation_drift.toml", "compensated.output"),
    Case("accelerometer/self_calibration_accelerometer.toml", "adc.number"),
    Case("accelerometer/self_calibration_online.toml", "adc.number"),
    Case("accelerometer/self_calibration_population.toml", "device.adc.number"),
    Case("accelerometer/self_calibration_gauss_newton.toml", "adc.number"),
    Case("accelerometer/self_calibration_in_operation.toml", "adc.number"),
    Case("accelerometer/self_calibration_fixed.toml", "adc.number"),
    Case("gyroscope/self_calibration_gyroscope.toml", "adc.number"),
    Case("accelerometer/self_test_population.toml", "axis.adc.number"),
    Case("gyroscope/imu_3dof.toml", "x.adc.number"),
)


@dataclass(frozen=True)
class Row:
    """What a budget predicts of an output, and what two runs show."""

    case: Case
    budget: NoiseBudget
    rms: float
    inside: float  # part of the lines
    seconds: float  # of processor time for the budget
    errors: float | None  # standard errors, of the scatter of many runs; None where the output wanders


def row(case: Case, runs: bool = False) -> Row:
    """Return the comparison of one output; that with many runs only where it is wanted."""
    graph = proofmass.read_graph(next(LIBRARY.rglob(Path(case.file).name)))
    began = time.process_time()
    budget = proofmass.noise(graph, case.output)
    seconds = time.process_time() - began
    noise = _noise(graph, case, budget)
    spectrum = proofmass.spectrum(noise, segment=case.segment)
    lines = spectrum.frequencies[_LINES]
    predicted = proofmass.noise(graph, case.output, frequencies=lines).density
    rms, inside = float(np.std(noise.values)), _inside(predicted, spectrum)
    return Row(case, budget, rms, inside, seconds, scatter(graph, case, budget) if runs else None)


def scatter(graph: Graph, case: Case, budget: NoiseBudget) -> float | None:
    """Return by how many standard errors the last values of many runs scatter more than the budget says."""
    if budget.band[0] > 0.0:
        return None
    stride = proofmass.simulate(replace(graph, probes=(read_probe(case.output),), measures={}), samples=1)
    ticks = LAST_VALUE * stride[case.output].stride
    last = {"last": Measure(case.output, "last")}
    study = proofmass.Study(replace(graph, probes=(), measures=last, duration=None, samples=ticks), runs=RUNS, seed=7)
    values = proofmass.run_study(study, engine="compiled").values["last"]
    return float((np.std(values, ddof=1) / budget.rms - 1.0) * np.sqrt(2.0 * RUNS))


def _noise(graph: Graph, case: Case, budget: NoiseBudget) -> Series:
    probed = replace(graph, probes=(read_probe(case.output),), measures={})
    stride = proofmass.simulate(probed, samples=1)[case.output].stride
    runs = [proofmass.simulate(probed, samples=case.values * stride, seed=seed)[case.output] for seed in (1, 2)]
    apart = (runs[0].values.astype(float) - runs[1].values) / np.sqrt(2.0)
    return Series(apart, 1.0 / budget.rate, case.output, budget.unit)


def _inside(predicted: Any, spectrum: Spectrum) -> float:
    """Part of the lines whose density is as likely as the confidence says."""
    known = predicted > 1e-6 * np.max(predicted)  # what leaks from elsewhere is more in the zeros of a hold
    low, high = chi2.ppf([0.5 - CONFIDENCE / 2.0, 0.5 + CONFIDENCE / 2.0], spectrum.freedom) / spectrum.freedom
    ratio = spectrum.density[_LINES][known] / predicted[known]
    return float(np.mean((low <= ratio) & (ratio <= high)))


def main() -> None:
    """Print the table."""
    print(
        f"{'graph':<38} {'output':<20} {'predicted':>11} {'of runs':>11} {'inside':>8} {'1,000 runs':>11} {'budget':>8}"
        "  largest source"
    )
    for case in CASES:
        if len(sys.argv) < 2 or sys.argv[1] in case.file:
            line = row(case, runs=True)
            first, errors = line.budget.sources[0], "" if line.errors is None else f"{line.errors:+.2f} SE"
            print(
                f"{Path(case.file).stem:<38} {case.output:<20} {line.budget.rms:11.4g} {line.rms:11.4g}"
                f" {100.0 * line.inside:6.1f} % {errors:>11} {line.seconds:6.2f} s"
                f"  {first.block} {100.0 * first.share:.0f} %",
                flush=True,
            )


if __name__ == "__main__":
    main()
