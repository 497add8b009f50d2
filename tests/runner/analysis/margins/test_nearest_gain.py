"""A loop that needs its gain: where one gain margin is shown, it is that to the nearer side."""

import math

import pytest

from proofmass import margins
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.analysis.margins.margins import least_of, margins_of
from proofmass.runner.analysis.margins.plot import plot_margins
from proofmass.runner.analysis.margins.sensitivity import margin_sensitivities
from proofmass.runner.analysis.several.over import margins_over
from proofmass.runner.commands.several_loops import _over_lines
from proofmass.runner.live.verdicts import verdicts
from proofmass.runner.planning.plan import plan
from tests.by_hand.needed_gain import GAIN, GRAPH, LEAST, MOST

DOWN, UP = 20.0 * math.log10(GAIN / LEAST), 20.0 * math.log10(MOST / GAIN)


@pytest.mark.defect(
    "S771", before="the margin to higher gain alone, 18.49 dB", after="7.96 dB, by which the gain may fall"
)
def test_one_number_is_the_nearer_limit() -> None:
    found = margins(GRAPH, "main")
    assert found.as_data()["gain_margin_db"] == pytest.approx(UP, rel=1e-9)
    assert found.least_gain_margin == pytest.approx(DOWN, rel=1e-9)
    assert "gain margin 7.96 dB" in repr(found)
    assert "gain margin 7.96 dB" in str(plot_margins(found).get_suptitle())
    chip = verdicts(GRAPH, True).verdicts[0]
    assert chip["value"].startswith("stable, 7.96 dB")
    over = margins_over(GRAPH, "gain.gain", [0.25])
    assert "7.959 dB" in "\n".join(_over_lines(over))


def test_its_derivative_is_that_of_the_nearer_limit() -> None:
    """20 log10(k / 0.1) moves by 0.0869 dB if k grows by 1 %."""
    about, wire = linearised(plan(GRAPH)), ("error", "output")
    system = about.loop(wire, by_parameters=True)
    found = margin_sensitivities(about.plan, margins_of(about.loop(wire), "main", "error.output"), system)[0]
    (effect,) = [e for e in found.effects if e.parameter == "gain.gain"]
    assert found.value == pytest.approx(DOWN)
    assert effect.of_one_percent == pytest.approx(0.2 / math.log(10.0), rel=1e-6)


def test_the_least_of_instants_is_that_of_the_nearer_limit() -> None:
    low, high = (margins(GRAPH.with_parameters({"gain.gain": k}), "main") for k in (0.2, 1.0))
    assert low.gain_margin is not None
    assert high.gain_margin is not None
    assert low.gain_margin > high.gain_margin
    assert least_of([high, low]).gain_reduction == low.gain_reduction


def test_no_limit() -> None:
    assert Figures(gain_margin=math.inf, gain_reduction=0.0).nearest_gain is None
    assert Figures().least_gain_margin == math.inf
    assert Figures(gain_margin=1.0, gain_reduction=0.5).least_gain_margin == 0.0
