"""What python-control says beside our margins: where it agrees, where it has no opinion, and that it can disagree."""

import dataclasses
import functools
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass import margins, read_graph
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.second_opinion import _grid, second_opinion
from proofmass.runner.analysis.margins.stability import margins_or_reasons
from proofmass.runner.planning.plan import plan
from tests.by_hand.amounts import chosen
from tests.by_hand.design_texts import INTEGRATING
from tests.runner.analysis.margins.test_margins import lifted

LIBRARY = ["closed_loop_accelerometer", "fibre_optic_gyroscope", "vibratory_gyroscope"]
MORE = [
    *("closed_loop_gyroscope", "coupled_axes", "drive_loop", "force_to_rebalance"),
    *("quartz_accelerometer", "resonant_accelerometer"),
]


@pytest.mark.exhaustive
@pytest.mark.friendly(30, "python-control's verdict stands beside")
def test_of_a_loop_with_a_closed_form() -> None:
    found = margins(read_graph_text(INTEGRATING))
    opinion = second_opinion(found)
    assert opinion.stable
    assert not opinion.differences
    assert opinion.gain_margin_db == pytest.approx(20.0, abs=1e-6), "z^2 - z + k has |z| = 1 at k = 1, ten times this"
    turn = 2.0 * math.asin(0.1 / 2.0)  # w T where |L| = 0.1 / (2 sin(w T / 2)) = 1
    assert opinion.phase_margin_deg == pytest.approx(90.0 - math.degrees(1.5 * turn), abs=1e-6)
    assert str(opinion).startswith("python-control agrees on ")


@pytest.mark.exhaustive
def test_it_can_disagree() -> None:
    found = margins(read_graph_text(INTEGRATING))
    assert found.gain_margin is not None
    wrong = dataclasses.replace(found, gain_margin=1.01 * found.gain_margin, phase_margin=None)
    opinion = second_opinion(wrong)
    assert [text.partition(" is ")[0] for text in opinion.differences] == ["our gain margin", "our phase margin"]
    assert "DISAGREES" in str(opinion)
    opinion = second_opinion(dataclasses.replace(found, verdict="unstable"))
    assert opinion.differences == ("we say unstable",)


def test_unstable_loops_have_a_verdict_alone_and_several_values_no_opinion() -> None:
    opinion = second_opinion(margins(read_graph_text(INTEGRATING.replace("gain = 100.0 ", "gain = 2000.0 "))))
    assert str(opinion) == "python-control agrees on main: unstable"
    assert second_opinion(margins(lifted(2))).reason == "a period holds 2 values of the wire"


@functools.cache
def of_library(name: str) -> list[Margins]:
    found = margins_or_reasons(OperatingPoints(plan(read_graph(f"library:{name}")), "auto"))
    return [one for one in found.values() if isinstance(one, Margins)]


@pytest.mark.exhaustive("fibre_optic_gyroscope", "vibratory_gyroscope")
@pytest.mark.parametrize("name", chosen(LIBRARY, MORE))
@pytest.mark.friendly(30, "it agrees on loops of the library")
def test_it_agrees_on_the_library(name: str) -> None:
    """It has none of loops with several values in a period, as the amplitude of the resonant accelerometer."""
    pairs = [(one, second_opinion(one)) for one in of_library(name)]
    assert [one for one, opinion in pairs if not opinion.reason]
    assert [opinion for _, opinion in pairs if opinion.differences] == []
    assert all(one.system.per_period > 1 for one, opinion in pairs if opinion.reason)


@pytest.mark.exhaustive
def test_modes_that_the_loop_does_not_see_do_not_count() -> None:
    (found,) = of_library("fibre_optic_gyroscope")
    assert found.hidden
    poles = abs(np.linalg.eigvals(found.system.map.parts()[0]))
    assert max(poles) >= 1.0 - 1e-12
    assert second_opinion(found).stable


def test_a_grid_ends_after_the_first_crossovers_of_a_long_delay() -> None:
    """It crosses at 1 Hz, 2 Hz and so on: those up to 8 Hz are looked for, and those from 40 Hz on are not."""
    system = SimpleNamespace(poles=lambda: np.array([-1.0]), dt=0)
    found: Any = SimpleNamespace(gain_crossovers=np.arange(1.0, 100.0), phase_crossovers=())
    last = _grid(system, found)[-1] / (2.0 * math.pi)
    assert 8.0 < last < 40.0
