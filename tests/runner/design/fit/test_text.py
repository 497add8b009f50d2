"""The report as text and as data: every number that matters, and JSON that any program reads."""

import json
from typing import Any

import pytest

from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.fit import fit
from proofmass.runner.design.fit.starts import from_starts
from proofmass.runner.design.fit.text import data, starts_text, text
from tests.by_hand.temperature_sets import M1, TEMPERATURE, fitted


def strict(report: Any) -> Any:
    """As a program reads it, which knows no NaN and no infinity."""
    written = json.dumps(report)
    return json.loads(written, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def test_text_compares_all_fits() -> None:
    report = fitted(M1)
    shown = text(report)
    assert "made: 61 rows, sensor [V] from 0.6 to 1.8, zero bias [V] from 0.00176241 to 0.00566241" in shown
    assert "peak to peak, 0.0039 before" in shown
    for model in report.fits:
        row = next(line for line in shown.splitlines() if model.model in line and model.method in line)
        assert row.split()[-4:-1] == [f"{model.rmse:.5g}", f"{model.r_squared:.5f}", f"{model.after:.5g}"]
        if model.method == "alternation":
            continue
        for c in model.coefficients:
            numbers = [f"{c.value:.8g}", "+-", f"{c.half_width:.2g}", c.unit]
            assert [*model.model.split(), c.name, *numbers] in [
                line.split() for line in shown.splitlines() if line.startswith(model.model)
            ]


def test_text_tells_what_is_wrong() -> None:
    line = Readings("made", TEMPERATURE, 3.0 * TEMPERATURE, "sensor", "bias")
    shown = text(fit(line, tolerance=1e-3))
    assert "not determined" in shown
    assert "b1, b2: the two exponents cannot be told apart" in shown
    assert "sensor from 0.6 to 1.8" in shown


def test_data_holds_the_same_numbers() -> None:
    report = fitted(M1)
    read = strict(data(report))
    assert read["rows"] == 61
    assert read["determined"] is True
    assert read["peak_to_peak"] == report.before
    for model, back in zip(report.fits, read["fits"], strict=True):
        assert {name: c["value"] for name, c in back["coefficients"].items()} == model.values
        assert back["rmse"] == model.rmse
        assert back["iterations"] == model.iterations
    assert "starts" not in read


def test_data_has_no_infinity() -> None:
    report = fit(Readings("made", TEMPERATURE[::15], M1.output()[::15], "sensor", "bias"), tolerance=1.0)
    read = strict(data(report))
    assert read["fits"][-1]["coefficients"]["c0"]["half_width"] is None
    assert read["determined"] is False
    assert next(finding["note"] for finding in read["findings"]) is False


@pytest.mark.exhaustive
def test_starts() -> None:
    arrivals = from_starts(fit(M1.readings(), tolerance=1e-3), (-0.6, -0.3, 0.6))
    shown = starts_text(arrivals)
    assert "alternation: 3 of 3 starts reach the optimum, in " in shown
    assert "variable projection: 2 of 3 starts" in shown
    assert "  not from b = (-1, -0.5): did not converge" in shown
    read = strict(data(fitted(M1), arrivals))["starts"]
    assert [arrival["reached"] for arrival in read["variable projection"]] == [False, True, True]
