"""What graphs say of the claims of Ran et al. 2019; docs/papers/quartz_claims.py has the rows."""

import functools
from typing import Any

import numpy as np

from docs.papers.quartz_accelerometer import (
    FIGURE_13,
    MICRO_G,
    PPM,
    SCALE_FACTOR,
    TABLE_4,
    Trial,
    disturbed,
    ideal,
    library,
    mean_output,
    ppm,
    study,
    with_converter,
)
from proofmass.blocks import FlexurePendulum, GapCapacitorPair, Ramp, Step
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.build import Study
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import run_study

TORQUE = 1e-9  # N m
RESTORED = 1.0 - FIGURE_13[1] / FIGURE_13[0]  # 87.56 % [P]


def deflection(changes: dict[str, float], seconds: float = 2.0) -> float:
    """Angle of the flexure pendulum of the library's graph under a constant torque, in rad."""
    pendulum = {"inertia": 1e-7, "damping": 4e-4, "stiffness": 3e-3} | changes
    graph = Graph(
        name="a torque",
        rate=20_000,
        blocks={"torque": Step(amplitude=TORQUE, unit="N*m"), "pendulum": FlexurePendulum(**pendulum)},
        wires=["torque.output -> pendulum.torque"],
        probes=["pendulum.angle"],
        duration=seconds,
    )
    return float(simulate(graph, engine="compiled")["pendulum.angle"].values[-1])


def printed(inertia: float = 1e-7, damping: float = 4e-4, stiffness: float = 3e-3) -> float:
    """The deflection by equations 2 and 3 as printed, M / (|s1| |s2|), in rad."""
    root = np.sqrt(damping**2 - 4.0 * stiffness * inertia)
    first, second = (abs((-damping + sign * root) / (2.0 * inertia)) for sign in (1.0, -1.0))
    return TORQUE / (first * second)


def missing_inertia() -> str:
    """Simulated deflection over M / D, and the printed one over it: J."""
    share = TORQUE / 3e-3
    return f"{deflection({}) / share:.4f} M/D; as printed {printed() / share:.1e} M/D, which is J"


def only_stiffness() -> str:
    """The deflection with twice the inertia and damping."""
    return f"{deflection({'inertia': 2e-7, 'damping': 8e-4}, 4.0) / deflection({}):.4f} with J and C twice as large"


def pickoff() -> str:
    """Slope of the capacitances over 2 C0 l / d."""
    graph = Graph(
        name="pickoff",
        rate=1000,
        blocks={"angle": Ramp(slope=1e-6, unit="rad"), "pair": GapCapacitorPair()},
        wires=["angle.output -> pair.displacement"],
        probes=["pair.first", "pair.second"],
        samples=1001,
    )
    result = simulate(graph)
    slope = (result["pair.first"].values[-1] - result["pair.second"].values[-1]) / 1e-6
    return f"{slope / (2.0 * 42.5e-12 * 10e-3 / 12.5e-6):.6f} of 2 C0 l / d"


def bias() -> str:
    """Of the imbalance of the reference capacitors."""
    return f"{mean_output({'specific_force.value': 0.0}) / SCALE_FACTOR / MICRO_G:.1f} ug by 0.2138 %"


@functools.cache
def one_g() -> float:
    """Mean code at 1 g."""
    return mean_output()


def moved(parameter: str, nominal: float) -> str:
    """What 1000 ppm of a parameter do to the output."""
    return f"{round(ppm((one_g(), mean_output({parameter: 1.001 * nominal}))), 1) + 0.0:.1f} ppm"


def found_forward() -> str:
    """By the sweep of the ideal graph."""
    return f"{ppm(ideal().forward):.2f} ppm"


def found_feedback() -> str:
    """By the switched current of the ideal graph."""
    return f"{ppm(ideal().feedback):+.2f} ppm"


def six(name: str) -> str:
    """Mean and deviation of six disturbed trials in ppm."""
    rows = [ppm(getattr(trial, name)) for trial in disturbed()]
    return f"{np.mean(rows):.1f} ppm, deviation {np.std(rows, ddof=1):.1f}"


def estimated(name: str, wanted: float) -> str:
    """The paper's percentage, of six disturbed trials."""
    rows = [100.0 * (1.0 - abs(ppm(getattr(trial, name)) - wanted) / abs(wanted)) for trial in disturbed()]
    return f"{np.mean(rows):.1f} %"


@functools.cache
def hundred() -> tuple[Any, Any]:
    """Errors before and after compensation of 100 disturbed trials, in ug."""
    values = run_study(study("quartz_drift_study_disturbed"), runs=100, engine="compiled").values
    before, after = (values[f"error_{when}"][:, 0] / MICRO_G for when in ("before", "after"))
    return before, after


def restrained() -> str:
    """What 100 trials remove, and how many remove no more than the paper's."""
    before, after = hundred()
    removed = 1.0 - np.abs(after) / np.abs(before)
    return (
        f"median {100.0 * np.median(removed):.1f} %; {int((removed <= RESTORED).sum())} of 100 trials at most 87.56 %"
    )


def figure_13() -> str:
    """Mean and deviation of 100 trials."""
    cells = (f"{np.mean(errors):.0f} +- {np.std(errors, ddof=1):.0f}" for errors in hundred())
    return " and ".join(cells) + " ug"


def arithmetic() -> str:
    """87.56 % and what the paper's own numbers say otherwise."""
    before, after = FIGURE_13
    estimate = float(np.mean([ppm(row) for row in TABLE_4]))
    left = before - estimate
    return (
        f"1 - {after:g}/{before:g} = {100.0 * (1.0 - after / before):.2f} %; but {before:g} - {estimate:.2f} = "
        f"{left:.2f} ug, {100.0 * (1.0 - abs(left) / before):.2f} %"
    )


def converter(bits: int) -> str:
    """Error that is left with a DA0 of so many bits."""
    trial: Trial = with_converter(bits)
    return f"{trial.errors[1]:.1f} ug with {bits} bits"


def stability() -> str:
    """Margins of the loop."""
    found = margins(library("quartz_accelerometer"), "da2.voltage").as_data()
    return f"{found['gain_margin_db']:.2f} dB, {found['phase_margin_deg']:.1f} deg"


def stuck() -> str:
    """How little acceleration puts the plate on its stop without a loop."""
    rest = deflection({}) / TORQUE  # rad per N m
    return f"{1.25e-3 / (rest * 8e-6 * 9.80665):.3f} g puts it on its stop"


@functools.cache
def terms(changes: tuple[tuple[str, object], ...] = (), spread: bool = True, runs: int = 100) -> Any:
    """Measures of the tests of so many months, by name."""
    graph = library("quartz_error_terms").with_parameters(dict(changes))
    of_months = {"months_bias": {"normal": "50 ug0"}, "months_scale": {"normal": "30 ppm"}} if spread else {}
    found = run_study(Study(graph, runs=runs, seed=1, spread=of_months), engine="compiled").values
    return {name: column[:, 0] for name, column in found.items()}


STEADY = (("bias_stability", 0.0),)


def bias_stability() -> str:
    """Mean over months of the scatter of averages of 10 s."""
    return f"{terms()['stability'].mean() / MICRO_G:.0f} ug"


def repeatability(measure: str, unit: float, name: str) -> str:
    """Scatter over months, of the term alone and in the presence of the others."""
    alone, all_ = (np.std(terms(changes)[measure], ddof=1) / unit for changes in (STEADY, ()))
    return f"{alone:.0f} {name} alone, {all_:.0f} with bias instability"


def linearity() -> str:
    """Distance from the line, without noise."""
    quiet = (*STEADY, ("axis.white.density", 0.0))
    return f"{terms(quiet, spread=False, runs=1)['linearity'][0] / PPM:.1f} ppm"
