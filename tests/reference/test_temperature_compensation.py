"""Liu, Li and Shen's temperature compensation: their figures, on sets and graphs built to give them."""

import dataclasses

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.design.fit.data import run_cycle
from proofmass.runner.design.fit.fit import fit
from proofmass.runner.run.simulate import simulate
from tests.by_hand.temperature_sets import DEVICES, Device, fitted

START = (-1.0, 1.0)

each = pytest.mark.parametrize("device", DEVICES.values(), ids=DEVICES)


@pytest.mark.exhaustive("m2")
@each
def test_peak_to_peak_before_and_after(device: Device) -> None:
    """Section 3: 0.0039 V to 3.6871e-4 V, 0.0019 V to 1.8413e-4 V."""
    report = fitted(device, START)
    assert report.before == pytest.approx(device.before, rel=1e-6)
    assert report.fits[0].after == pytest.approx(device.after, rel=1e-5)


@each
def test_two_exponentials_are_as_good_as_the_fourth_order(device: Device) -> None:
    """Tables 1 and 2, whose numbers are lost; these are of an independent computation."""
    double, _, third, fourth = fitted(device, START).fits
    fits = (double, third, fourth)
    assert [f.rmse for f in fits] == pytest.approx(device.rmse, rel=1e-4)
    assert [f.r_squared for f in fits] == pytest.approx(device.r_squared, abs=1e-5)
    assert double.rmse < fourth.rmse < third.rmse


@each
def test_alternation_reaches_the_optimum_in_thousands_of_iterations(device: Device) -> None:
    report = fitted(device, START)
    projected, alternated = report.fits[:2]
    assert alternated.converged
    assert alternated.rmse == pytest.approx(projected.rmse, rel=1e-6)
    assert alternated.iterations == pytest.approx(device.iterations, rel=2e-3)
    assert report.rate == pytest.approx(device.rate, abs=6e-5)
    assert projected.iterations < 50
    assert report.findings == ()


@pytest.mark.exhaustive("kelvins")
@pytest.mark.parametrize(("coldest", "iterations"), [(-40.0, 452), (233.15, 17_901)], ids=["Celsius", "kelvins"])
def test_the_way_of_the_alternation_depends_on_the_origin(coldest: float, iterations: int) -> None:
    volts = DEVICES["m1"].readings()
    degrees = dataclasses.replace(volts, temperature=coldest + 125.0 * (volts.temperature - 0.6) / 1.2)
    projected, alternated = fit(degrees, []).fits
    assert alternated.iterations == pytest.approx(iterations, rel=2e-2)
    assert projected.rmse == pytest.approx(DEVICES["m1"].rmse[0], rel=1e-4)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", DEVICES)
def test_graph_calibrated_in_one_cycle_and_compensated_in_others(name: str) -> None:
    graph, device = read_graph(library_file(f"temperature_compensation_{name}.toml")), DEVICES[name]
    report = fit(run_cycle(graph, "thermometer.voltage", "noisy.output"), tolerance=1e-3)
    assert report.before == pytest.approx(device.before, rel=1e-3)
    assert report.fits[0].after == pytest.approx(device.after, rel=1e-3)
    shipped = [getattr(graph.blocks["model"], c.name) for c in report.fits[0].coefficients]
    assert list(report.fits[0].values.values()) == pytest.approx(shipped, rel=1e-6)
    slower = {
        "chamber.pace": "0.5 K/min",
        "chamber.soak_time": "1 h",
        "chamber.low": "253.15 K",
        "chamber.high": "338.15 K",
    }
    for changes in ({}, slower):
        result = simulate(graph.with_parameters(changes), seed=2)
        before, after = (np.ptp(result[signal].values) for signal in ("noisy.output", "compensated.output"))
        assert after < 1.02 * device.after
        assert after < before / 4.0
