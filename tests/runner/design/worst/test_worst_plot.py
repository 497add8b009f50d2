"""The picture of worst cases has a row for each parameter that can be seen, and names the others."""

import pytest

from proofmass import read_study, worst
from proofmass.graphs.files.library import library_file
from proofmass.runner.design.worst.plot import plot_worst


@pytest.mark.friendly(29, "worst cases have no empty rows")
def test_a_parameter_without_a_bar_has_no_row() -> None:
    cases = worst(read_study(library_file("margin_tolerance_study.toml")), samples=1)
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
