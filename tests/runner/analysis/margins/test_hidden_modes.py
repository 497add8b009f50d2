"""Loops with modes that they do not see: named, left out, and no reason to call a loop unstable."""

import math

import numpy as np
import pytest

from proofmass.blocks import (
    PID,
    Constant,
    Difference,
    DiscreteIntegrator,
    DiscreteTransferFunction,
    Gain,
    LowPass,
    Step,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.linearise import linearise, node_of
from proofmass.runner.analysis.margins.sensitivity import transfer_sensitivities
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.planning.plan import plan


def ramp_loop(gain: float) -> Graph:
    """An integrator and, behind it, a difference that takes it back: L = g z^-1 / (z - 1), g = gain / 1 kHz."""
    return Graph(
        name="a ramp and its steps",
        rate="1 kHz",
        blocks={
            "source": Constant(value=1.0),
            "error": Difference(),
            "controller": DiscreteIntegrator(gain=gain, output_unit="1"),
            "ramp": DiscreteIntegrator(gain=1000.0, output_unit="1"),
            "delayed": UnitDelay(),
            "fed_back": Difference(),
        },
        wires=[
            "source.output -> error.first",
            "fed_back.output -> error.second",
            "error.output -> controller.input",
            "controller.output -> ramp.input",
            "ramp.output -> delayed.input",
            "ramp.output -> fed_back.first",
            "delayed.output -> fed_back.second",
        ],
        loops={"main": {"open_at": "controller.output"}},
    )


def decimated(integrators_and_combs: bool) -> Graph:
    """A CIC filter of second order by 8 in a loop, as integrators and combs, or as the triangular filter that it is."""
    blocks: dict[str, Block] = {
        "reference": Step(amplitude=1.0),
        "error": Difference(),
        "plant": LowPass(corner_frequency=200.0),
        "scale": Gain(gain=1.0 / 64.0),
        "control": PID(proportional=1.0, integral=1000.0, derivative_gain=0.0),
    }
    wires = [
        "reference.output -> error.first",
        "scale.output -> error.second",
        "error.output -> control.error",
        "control.output -> plant.input",
    ]
    slow = ["reference", "error", "scale", "control"]
    if integrators_and_combs:
        for name in ("first", "second"):
            blocks[f"{name}_sum"] = DiscreteIntegrator(gain=64e3, output_unit="1")
            blocks |= {f"{name}_before": UnitDelay(), f"{name}_comb": Difference()}
            slow += [f"{name}_before", f"{name}_comb"]
        wires += [
            "plant.output -> first_sum.input",
            "first_sum.output -> second_sum.input",
            "second_sum.output -> first_comb.first",
            "second_sum.output -> first_before.input",
            "first_before.output -> first_comb.second",
            "first_comb.output -> second_comb.first",
            "first_comb.output -> second_before.input",
            "second_before.output -> second_comb.second",
            "second_comb.output -> scale.input",
        ]
    else:
        triangle = np.convolve(np.ones(8), np.ones(8))
        taps = (0.0, 0.0, *triangle)  # both integrators give what they held before
        blocks["filter"] = DiscreteTransferFunction(numerator=taps, denominator=(1.0, *[0.0] * (len(taps) - 1)))
        wires += ["plant.output -> filter.input", "filter.output -> scale.input"]
    return Graph(
        name="decimated",
        rate="64 kHz",
        blocks=blocks,
        rates=dict.fromkeys(slow, "8 kHz"),
        wires=wires,
        loops={"main": {"open_at": "control.output"}},
    )


@pytest.mark.defect("S11", before="stable or UNSTABLE by the last bit of the gain", after="stable below 1000 1/s")
@pytest.mark.parametrize("gain", [37.0, 61.0, 100.0, 130.0, 170.0, 211.0])
def test_a_pole_that_a_zero_cancels_is_named_and_left_out(gain: float) -> None:
    """The closed loop is z^2 - z + g: stable for 0 < g < 1."""
    found = margins(ramp_loop(gain))
    assert found.verdict == "stable"
    assert found.gain_margin == pytest.approx(1000.0 / gain, rel=1e-12)
    assert np.sort_complex(found.poles) == pytest.approx(np.sort_complex(np.roots([1.0, -1.0, gain / 1000.0])))
    assert [str(mode) for mode in found.hidden] == ["an integrator that the loop does not see: ramp, delayed"]


@pytest.mark.defect("S12", before="scale factor 0, LinAlgError or does not settle", after="scale factor 1")
@pytest.mark.parametrize("gain", [100.0, 300.0])
def test_the_scale_factor_of_a_loop_with_a_hidden_integrator(gain: float) -> None:
    """The controller settles where the steps of the ramp equal the source: 1 / (ramp gain / rate)."""
    graph = ramp_loop(gain)
    planned = plan(graph)
    nodes = (node_of(planned, signal) for signal in ("source.output", "controller.output"))
    scale, bias = transfer_sensitivities(linearised(planned), *nodes)
    assert scale.value == pytest.approx(1.0, rel=1e-12)
    assert bias.value == 0.0
    assert [(e.parameter, pytest.approx(e.derivative)) for e in scale.effects] == [("ramp.gain", -1e-3)]


def test_a_minimal_linearisation_has_no_hidden_integrator() -> None:
    """From source to controller: g z / (z^2 - z + g), without the pole at 1 that the ramp has."""
    graph = ramp_loop(100.0)
    ends = (["source.output"], ["controller.output"])
    whole, minimal = (linearise(graph, *ends, minimal=minimal) for minimal in (False, True))
    assert np.min(np.abs(whole.poles() - 1.0)) < 1e-12
    assert np.sort_complex(minimal.poles()) == pytest.approx(np.sort_complex(np.roots([1.0, -1.0, 0.1])), abs=1e-12)
    z = np.exp(0.3j)
    assert complex(minimal(z)) == pytest.approx(0.1 * z / (z * z - z + 0.1), rel=1e-12)
    assert complex(whole(z)) == pytest.approx(0.1 * z / (z * z - z + 0.1), rel=1e-12)


def test_what_does_not_settle_is_refused_with_the_blocks_that_hold_it() -> None:
    graph = ramp_loop(100.0)
    planned = plan(graph)
    nodes = (node_of(planned, signal) for signal in ("source.output", "ramp.output"))
    with pytest.raises(ModelError, match=r"ramp\.output does not settle") as caught:
        transfer_sensitivities(linearised(planned), *nodes)
    assert "in ramp, delayed" in caught.value.problems[0].got


@pytest.mark.defect("S4", before="UNSTABLE by integrators behind combs", after="16.63 dB and 84.75 deg, as the FIR")
def test_a_cic_filter_in_a_loop_is_the_fir_filter_that_it_is() -> None:
    combs, taps = margins(decimated(True)), margins(decimated(False))
    assert (combs.verdict, taps.verdict) == ("stable", "stable")
    for name in ("gain_margin", "phase_margin", "delay_margin", "disk_margin", "sensitivity_peak", "bandwidth"):
        assert getattr(combs, name) == pytest.approx(getattr(taps, name), rel=1e-9), name
    assert 20.0 * math.log10(combs.gain_margin or 0.0) == pytest.approx(16.63, abs=0.005)
    assert math.degrees(combs.phase_margin or 0.0) == pytest.approx(84.75, abs=0.005)
    (mode,) = combs.hidden
    assert mode.times == 2
    assert {"first_sum", "second_sum"} <= set(mode.blocks)


def test_a_pole_on_the_circle_that_the_loop_sees_is_marginal() -> None:
    """L = 1/z: the closed loop has its pole at -1, whatever the rounding."""
    blocks: dict[str, Block] = {"delay": UnitDelay(), "back": Gain(gain=-1.0)}
    wires = ["delay.output -> back.input", "back.output -> delay.input"]
    found = margins(Graph(name="ring", rate="1 kHz", blocks=blocks, wires=wires))
    assert found.verdict == "marginal"
    assert found.distance == 0.0
