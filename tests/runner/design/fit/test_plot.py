"""The picture of a fit: its curves and residuals are those of the report, named, with units."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from proofmass.runner.design.fit.data import Readings
from proofmass.runner.design.fit.fit import fit
from proofmass.runner.design.fit.plot import plot_fit
from proofmass.runner.output.pictures import save_figure
from tests.by_hand.temperature_sets import M1, TEMPERATURE


def test_panels_curves_and_labels() -> None:
    report = fit(M1.readings(), tolerance=1.0)
    figure = plot_fit(report)
    top, *below = figure.axes
    assert top.get_ylabel() == "zero bias [mV]"
    assert below[-1].get_xlabel() == "sensor [V]"
    assert [text.get_text() for text in top.get_legend().get_texts()] == [
        "readings", "two exponentials", "polynomial of order 3", "polynomial of order 4",
    ]  # fmt: skip
    assert top.lines[0].get_ydata() == pytest.approx(1e3 * M1.output())
    assert top.lines[1].get_ydata() == pytest.approx(1e3 * (M1.output() - report.fits[0].residual))
    drawn = [fitted for fitted in report.fits if fitted.method != "alternation"]
    assert len(below) == len(drawn)
    for panel, fitted in zip(below, drawn, strict=True):
        assert panel.lines[1].get_ydata() == pytest.approx(1e6 * fitted.residual)
        assert panel.get_ylim() == below[0].get_ylim()
        assert fitted.model in panel.get_title(loc="left")
        assert f"{fitted.rmse * 1e6:.4g} µV" in panel.get_title(loc="left")


@pytest.mark.exhaustive
def test_the_same_bytes_every_time(tmp_path: Path) -> None:
    report = fit(M1.readings(), tolerance=1.0)
    first, second = (save_figure(plot_fit(report), tmp_path / name).read_bytes() for name in ("a.svg", "b.svg"))
    assert first == second


@pytest.mark.exhaustive
def test_names_that_look_like_formulas_and_no_units(tmp_path: Path) -> None:
    bare = dataclasses.replace(M1.readings(), temperature_unit="", output_unit="", output_name="$x^{2$")
    figure = plot_fit(fit(bare, tolerance=1.0))
    assert figure.axes[0].get_ylabel() == r"\$x^{2\$"
    save_figure(figure, tmp_path / "a.png")


@pytest.mark.exhaustive
def test_many_readings_and_an_exact_fit(tmp_path: Path) -> None:
    temperature = np.tile(TEMPERATURE, 300)
    exact = np.exp(-2.0 * temperature) + np.exp(temperature)
    report = fit(Readings("long", temperature, exact, "T", "V"), [], tolerance=1.0)
    figure = plot_fit(report)
    assert len(figure.axes[0].lines[0].get_xdata()) == 4000
    save_figure(figure, tmp_path / "a.png")
