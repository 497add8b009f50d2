"""What is said of a loop that does not keep its requirements, from margins that were written by hand."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from proofmass import margins, read_graph
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.analysis.linearisation.poles import Pole
from proofmass.runner.analysis.margins.figures import Figures
from proofmass.runner.analysis.margins.margins import least_of
from proofmass.runner.analysis.margins.stability import _missed


def missed(loop: dict[str, float], **facts: Any) -> list[Problem]:
    """A stable sampled loop with 10 dB, 30 degrees, no limit of a delay, and a peak of 2, but for some facts."""
    known = {"stable": True, "verdict": "unstable", "slowest": [Pole(1.25 + 0j, -0.25, 1e-12)], "stable_gains": []}
    known |= {
        "system": SimpleNamespace(continuous=False),
        "open_at": "gain.output",
    }
    figures = {"gain_margin": 10.0**0.5, "phase_margin": math.radians(30.0), "sensitivity_peak": 2.0}
    values = Figures(**{**figures, **{key: fact for key, fact in facts.items() if key == "delay_margin"}}).value
    found = SimpleNamespace(**{**known, "value": values, "attained": values, **facts})
    return list(_missed("main", SimpleNamespace(requirements=loop), found))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("pole", "continuous", "told"),
    [
        (Pole(1.25 + 0j, -0.25, 1e-12), False, "a closed-loop pole of size 1.25"),
        (Pole(1.000001 + 0j, -1e-6, 1e-12), False, "a closed-loop pole 1e-06 outside the unit circle"),
        (Pole(3.5 + 0j, -3.5, 1e-12), True, "a closed-loop pole at 3.5+0j 1/s"),
        (Pole(1.0 + 0j, 1e-13, 2e-12), False, "a closed-loop pole on the boundary of stability, but for what rounding"),
    ],
)
def test_a_loop_that_is_not_stable_keeps_no_requirement(pole: Pole, continuous: bool, told: str) -> None:
    limits = {"gain_margin": 3.0, "phase_margin": 20.0}
    (problem,) = missed(limits, stable=False, slowest=[pole], system=SimpleNamespace(continuous=continuous))
    assert (problem.message, problem.key, problem.path) == (
        "the loop is unstable",
        "loops.main.gain_margin",
        ("loops", "main", "gain_margin"),
    )
    assert (problem.got or "").startswith(told)
    assert (problem.hint or "").startswith("no factor at gain.output makes it stable")


@pytest.mark.parametrize(
    ("gains", "words"), [([(0.1, 0.5), (2.0, math.inf)], "above 2"), ([(0.125, 0.5)], "between 0.125 and 0.5")]
)
def test_the_last_range_of_factors_is_named(gains: list[tuple[float, float]], words: str) -> None:
    (problem,) = missed({"gain_margin": 3.0}, stable=False, stable_gains=gains)
    assert problem.hint == f"a factor {words} at gain.output makes it stable"


def test_limits_that_are_kept_and_missed() -> None:
    """A peak of 2 is 6.02 dB; a margin without limit keeps every one."""
    peak = 20.0 * math.log10(2.0)
    kept = {"gain_margin": 10.0, "phase_margin": 30.0 - 1e-9, "delay_margin": 1e9, "sensitivity_peak": peak}
    assert not missed(kept)
    found = missed({"delay_margin": 1e9, "gain_margin": 10.5, "phase_margin": 31.0, "sensitivity_peak": 6.0})
    assert [(p.message, p.got, p.expected) for p in found] == [
        ("the gain margin of the loop is not kept", "10 dB", "at least 10.5 dB"),
        ("the phase margin of the loop is not kept", "30 deg", "at least 31 deg"),
        ("the sensitivity peak of the loop is not kept", "6.021 dB", "at most 6 dB"),
    ]
    (late,) = missed({"delay_margin": 2e-3}, delay_margin=1e-3)
    assert (late.got, late.expected) == ("0.001 s", "at least 0.002 s")


@pytest.mark.defect(
    "S1032", before="a phase margin of 50 deg, that of the instant with the least gain margin", after="30"
)
def test_what_is_required_holds_at_every_instant_ahead() -> None:
    """One instant has the least gain margin, another one the least phase and delay margin, a third the highest peak."""
    known = margins(read_graph("library:closed_loop_accelerometer"))
    figures = [
        {"gain_margin": 2.0, "phase_margin": math.radians(50.0), "delay_margin": 3e-3, "sensitivity_peak": 1.5},
        {"gain_margin": 4.0, "phase_margin": math.radians(30.0), "delay_margin": 1e-3, "sensitivity_peak": 1.6},
        {"gain_margin": 5.0, "phase_margin": math.radians(60.0), "delay_margin": None, "sensitivity_peak": 2.0},
    ]
    instants = [replace(known, **{"gain_reduction": None, **of}) for of in figures]
    least = least_of([*instants, replace(known, verdict="unstable")])
    assert least.gain_margin == pytest.approx(2.0)
    expected = {"gain_margin": 20.0 * math.log10(2.0), "phase_margin": 30.0, "delay_margin": 1e-3}
    expected["sensitivity_peak"] = 20.0 * math.log10(2.0)
    assert {name: least.attained(name) for name in expected} == pytest.approx(expected)
    assert least.as_data()["worst_phase_margin_deg"] == pytest.approx(30.0)
