"""Curves of the variants of a sweep: one for each value of the other parameters."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass import read_variants, run_study
from proofmass.runner.studies.shown import curves

TAPS = ([0.001, 0.002], [1.0, 2.0], [1.0, 5.0])
FILTERS = f"""
name = "filters"
rate = "1 kHz"
samples = 3
wires = ["source.output -> filter.input"]
measures.last = {{ signal = "filter.output", statistic = "last" }}
blocks.source = {{ kind = "Constant", value = 1, unit = "V" }}
blocks.filter = {{ kind = "FiniteImpulseResponse", input_unit = "V", output_unit = "V" }}
[study]
runs = 2
spread = {{ "source.value" = {{ values = [1.0] }} }}
sweep = {{ "filter.taps" = {[*TAPS]} }}
"""


class Result:
    """A measure of two sensors at two ages."""

    measures = (SimpleNamespace(name="bias", unit="V"),)

    def __init__(self, last: float) -> None:
        self.values = {"bias": np.array([[9.0, last], [9.0, last + 1.0]])}

    def __getitem__(self, name: str) -> Any:
        return self.values[name]

    def of_draws(self, values: Any) -> Any:
        return values

    def unit_of(self, name: str) -> str:
        return "V" if name == "bias" else ""


def test_variants_are_curves_over_one_parameter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two gains and two masses, over the gain a curve of each mass, at the last age."""
    drawn: list[Any] = []
    monkeypatch.setattr(curves, "_drawn", lambda known, key, *_: drawn.append((known, key)) or "")
    names = {f"gain = {gain}, mass = {mass}": (gain, mass) for gain in (1, 2) for mass in (5, 7)}
    results = {name: Result(10.0 * gain + mass) for name, (gain, mass) in names.items()}
    swept = {name: {"gain": str(gain), "mass": str(mass)} for name, (gain, mass) in names.items()}
    curves._over(results, swept, "gain")  # type: ignore[arg-type]
    ((known, key),) = drawn
    assert key == "gain"
    assert {name: [(at, column.tolist(), mean) for at, column, mean in points] for name, points in known.items()} == {
        "mass = 5": [(1.0, [15.0, 16.0], 15.5), (2.0, [25.0, 26.0], 25.5)],
        "mass = 7": [(1.0, [17.0, 18.0], 17.5), (2.0, [27.0, 28.0], 27.5)],
    }


@pytest.fixture
def filters(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The figure over lists of taps, and its measure: 1 V behind each filter is the sum of its taps."""
    (tmp_path / "filters.toml").write_text(FILTERS)
    drawn: list[Any] = []
    drawing = curves.plot_curves
    monkeypatch.setattr(curves, "plot_curves", lambda *told: drawn.append((drawing(*told), told[2])) or drawn[-1][0])
    studies = read_variants(tmp_path / "filters.toml")
    assert curves.variant_pictures({name: run_study(study, engine="python") for name, study in studies.items()})
    ((figure, measure),) = drawn
    return figure.axes[0], measure


@pytest.mark.defect("S990", before="3 V beside 3 mV, each drawn as 3 mV", after="3 V and 0.003 V")
def test_variants_are_drawn_in_one_unit(filters: Any) -> None:
    panel, measure = filters
    heights = [line.get_ydata() for line in panel.lines]
    assert measure.unit == "V"
    assert sorted(np.concatenate(heights)) == pytest.approx(sorted(map(sum, TAPS)))


@pytest.mark.defect(
    "S991", before="lists with one first entry at one place, cut at the comma", after="a place for each"
)
def test_each_list_of_a_sweep_has_a_place_with_its_name(filters: Any) -> None:
    panel, _ = filters
    (line,) = panel.lines
    assert line.get_xdata().tolist() == [0.0, 1.0, 2.0]
    assert [re.findall(r"[0-9.]+", tick.get_text()) for tick in panel.get_xticklabels()] == [
        [str(tap) for tap in taps] for taps in TAPS
    ]


GROUPS = """
name = "groups"
rate = "1 kHz"
samples = 3
wires = ["source.output -> gain.input"]
measures.last = { signal = "gain.output", statistic = "last" }
blocks.source = { kind = "Constant", value = 1, unit = "V" }
blocks.gain = { kind = "Gain", input_unit = "V", output_unit = "V" }
[study]
runs = 7
design = "saltelli"
spread = { "source.value" = { uniform = "0.5 V" } }
sweep = { "gain.gain" = [1.0, 2.0] }
"""


@pytest.mark.defect("S1042", before="a mean line of runs, of a group that is not whole too", after="of groups")
def test_the_mean_line_counts_each_group_of_saltelli_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A group of one parameter has three runs; seven runs are two groups, and one of a single run."""
    (tmp_path / "groups.toml").write_text(GROUPS)
    (study,) = read_variants(tmp_path / "groups.toml").values()
    result = run_study(study, engine="python")
    figures: list[Any] = []
    monkeypatch.setattr(curves, "picture", lambda figure, _: figures.append(figure) or "")
    curves.sweep_picture(result, result.measures[0], "gain.gain")
    ((panel,),) = (figure.axes for figure in figures)
    seven = result["last"][::2, 0]
    groups = (seven[:3].sum() / 3.0 + seven[3:6].sum() / 3.0 + seven[6]) / 3.0
    assert abs(seven.mean() / groups - 1.0) > 1e-3
    assert panel.lines[0].get_ydata() == pytest.approx([groups, 2.0 * groups])
