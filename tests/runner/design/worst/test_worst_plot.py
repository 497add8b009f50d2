"""The picture of worst cases has a row for each parameter that can be seen, and names the others."""

from types import SimpleNamespace
from typing import Any

import pytest

from proofmass import read_study, worst
from proofmass.graphs.files.library import library_file
from proofmass.runner.design.worst.plot import _bars, plot_worst
from proofmass.runner.design.worst.worst import OneAtATime


def test_bars_of_half_a_hundredth_of_the_longest_are_seen() -> None:
    """Of 1000, or of all together: the longest first, and 15 of them."""
    ends = {"a": (0.0, 6.0), "b": (0.0, 1000.0), "c": (-5.0, 0.0), "d": (0.0, None), "e": (3.0, 5.001)}
    singles = [OneAtATime(name, low, high) for name, (low, high) in ends.items()]
    case: Any = SimpleNamespace(one_at_a_time=singles, nominal=0.0, worst=None)
    assert [single.parameter for single in _bars(case)] == ["d", "b", "a", "e"]
    case.worst = -1100.0
    assert [single.parameter for single in _bars(case)] == ["d", "b", "a"]
    case.one_at_a_time = [OneAtATime(f"p{k}", 0.0, 100.0 - k) for k in range(20)]
    assert [single.parameter for single in _bars(case)] == [f"p{k}" for k in range(15)]


@pytest.mark.friendly(29, "worst cases have no empty rows")
def test_a_parameter_without_a_bar_has_no_row() -> None:
    gain = {"gain": {"loop": "main", "figure": "gain_margin"}}
    cases = worst(read_study(library_file("margin_tolerance_study.toml")), gain, samples=1)
    for panel, case in zip(plot_worst(cases).axes, cases.cases, strict=True):
        *names, last = [label.get_text() for label in panel.get_yticklabels()]
        assert last == "all together"
        assert {"pickoff.gain", "pendulum.damping"} <= {*names}
        widths = [abs(bar.get_width()) for bar in panel.patches]
        longest = [max(widths[2 * row : 2 * row + 2]) for row in range(len(names))]
        assert longest == sorted(longest, reverse=True)
        assert min(longest) > 0.005 * max(widths)
        unseen = {single.parameter for single in case.one_at_a_time} - {*names}
        assert "pendulosity.gain" in unseen
        assert all(name in panel.get_xlabel() for name in unseen)
