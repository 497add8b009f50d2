"""The digital quartz accelerometer of Ran et al. 2019: the paper's tables beside those of the graphs in the library.

    python -m docs.papers.quartz_accelerometer

Labels: [P] is in the paper; [A] an assumption, for it has no parameters; [C] a conjecture that fits its numbers.
"""

import functools
from collections.abc import Iterator, Mapping
from importlib.resources import as_file
from typing import Any, NamedTuple

import numpy as np

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import run_study

PPM, MICRO_G = 1e-6, 9.80665e-6
TABLE_3 = [  # [P] k_pre-eq0, k_pre-eq1
    (478.9735, 478.8887), (478.9761, 478.8861), (478.9697, 478.8828),
    (478.9771, 478.8909), (478.9706, 478.8851), (478.9764, 478.8910),
]  # fmt: skip
TABLE_4 = [  # [P] N_on - N_off before and after
    (-71738.78, -71754.78), (-71738.14, -71753.42), (-71739.28, -71754.92),
    (-71739.21, -71754.63), (-71739.03, -71755.17), (-71738.67, -71754.09),
]  # fmt: skip
FIGURE_13 = (193.0, 24.0)  # [P] ug before and after compensation
FEEDBACK_CURRENT = 1.0002266e-3  # [A] A
CODES_PER_AMPERE = 342.0 * 2**19 / 2.5  # [A] 1 / (k_VI k_DA)
SCALE_FACTOR = -8.0e-6 / 0.065 * CODES_PER_AMPERE  # [A] -K0 / (kt k_VI k_DA), codes per m/s^2


@functools.cache
def library(name: str) -> Graph:
    """A graph of the library."""
    with as_file(library_file(f"{name}.toml")) as path:
        return read_graph(path)


def run(name: str, changes: Mapping[str, object] | None = None, **options: Any) -> Result:
    """A run of a graph of the library with parameters changed."""
    return simulate(library(name).with_parameters(changes or {}), engine="compiled", **options)


def at_end(result: Result, signal: str) -> float:
    """Last value of a probe."""
    return float(result[signal].values[-1])


class Trial(NamedTuple):
    """What one run of the whole procedure finds: gains before and after, errors of the static tests in ug."""

    forward: tuple[float, float]
    feedback: tuple[float, float]
    errors: tuple[float, float]


def trial(measures: Mapping[str, float]) -> Trial:
    """A run of the procedure by its measures."""
    forward, feedback, errors = (
        (measures[f"{name}_before"], measures[f"{name}_after"]) for name in ("forward", "feedback", "error")
    )
    return Trial(forward, feedback, (errors[0] / MICRO_G, errors[1] / MICRO_G))


def study(name: str) -> Study:
    """A study of the library."""
    with as_file(library_file(f"{name}.toml")) as path:
        return read_study(path)


@functools.cache
def ideal() -> Trial:
    """The procedure without disturbances."""
    return trials(study("quartz_drift_study"))[0]


@functools.cache
def disturbed() -> tuple[Trial, ...]:
    """Six trials under the disturbances that are conjectured [C]."""
    return trials(study("quartz_drift_study_disturbed"))


def trials(wanted: Study) -> tuple[Trial, ...]:
    """Every run of a drift study."""
    values = run_study(wanted, engine="compiled").values
    rows = zip(*(column[:, 0].tolist() for column in values.values()), strict=True)
    return tuple(trial(dict(zip(values, row, strict=True))) for row in rows)


@functools.cache
def with_converter(bits: int) -> Trial:
    """The procedure with a DA0 of so many bits."""
    found = run("quartz_calibration", {"accelerometer.da0.bits": bits, "n_vref.initial": 1 << (bits - 1)})
    return trial({name: measure.value for name, measure in found.measures.items()})


@functools.cache
def scatter(seconds: int, pattern: str) -> float:
    """Standard deviation of a feedback measurement that takes so many seconds, in ppm, over 100 of them."""
    slots = 2 if pattern == "once" else seconds // 5
    changes = {"slots.slots": slots, "slots.averaging": seconds / slots - 0.3, "pattern.palindrome": pattern == "ABBA"}
    result = run("quartz_feedback_noise", changes, duration=100 * seconds + 1, seed=seconds)
    differences = result["estimator.difference"].values[np.flatnonzero(result["estimator.estimated"].values)]
    return float(np.std(differences, ddof=1) / np.abs(differences.mean()) / PPM)


def mean_output(changes: Mapping[str, object] | None = None) -> float:
    """Mean code of the closed loop once it has settled."""
    return float(run("quartz_accelerometer", changes, samples=75_000)["da2.code"].values[25_000:].mean())


def ppm(pair: tuple[float, float]) -> float:
    """Relative change, in ppm."""
    return (pair[1] / pair[0] - 1.0) / PPM


def estimates(title: str, paper: list[tuple[float, float]], ours: list[tuple[float, float]], exact: tuple[float, float],
              digits: int) -> Iterator[str]:  # fmt: skip
    """A table of six estimates beside ours."""
    yield title
    yield f"{'':19}{'paper [P]':23}{'':13}disturbed graph [C]"
    yield f"{'':6}" + f"{'before':>13}{'after':>13}{'ppm':>10}" * 2
    for n, (theirs, found) in enumerate(zip(paper, ours, strict=True), 1):
        yield f"{n:<6}" + "".join(f"{a:13.{digits}f}{b:13.{digits}f}{ppm((a, b)):10.2f}" for a, b in (theirs, found))
    for name, statistic in (("mean", np.mean), ("std", functools.partial(np.std, ddof=1))):
        columns = [(*np.transpose(rows), [ppm(row) for row in rows]) for rows in (paper, ours)]
        cells = ([float(statistic(column)) for column in side] for side in columns)
        yield f"{name:<6}" + "".join(f"{a:13.{digits}f}{b:13.{digits}f}{c:10.2f}" for a, b, c in cells)
    yield f"ideal {exact[0]:49.{digits}f}{exact[1]:13.{digits}f}{ppm(exact):10.2f}"


def closed_forms() -> Iterator[str]:
    """What follows from the parameters on paper, beside the simulated loop."""
    yield "Closed forms [A]                                      by formula      simulated"
    rest, one_g = (mean_output({"specific_force.value": a}) for a in (0.0, 9.80665))
    yield f"{'scale factor -K0/(kt kVI kDA), codes per m/s^2':50}{SCALE_FACTOR:14.4f} {(one_g - rest) / 9.80665:14.4f}"
    switched = -FEEDBACK_CURRENT * CODES_PER_AMPERE
    yield f"{'N_on - N_off = -I_ref/(kVI kDA)':50}{switched:14.2f} {ideal().feedback[0]:14.2f}"
    slope = 2.5 / 2**17 * 3.0 * 10.0 * (1.0 - 42.590865 / 85.0) * 2**23 / 5.0
    yield f"{'k_pre-eq, eq. 15 and 16':50}{slope:14.4f} {ideal().forward[0]:14.4f}"
    moved = (("reference of DA2 + 1000 ppm", "da0.reference", 5.0, -1e3 / 1.001), ("sampling resistor + 1000 ppm",
             "converter.resistance", 342.0, 1e3), ("torquer + 1000 ppm", "torquer.gain", 0.065, -1e3 / 1.001),
             ("reference of DA1 + 1000 ppm", "da1.reference", 2.5, 0.0))  # fmt: skip
    for title, parameter, nominal, expected in moved:
        found = ppm((one_g, mean_output({parameter: 1.001 * nominal})))
        yield f"{'output, ' + title + ': ppm':50}{expected:14.2f} {found + 0.0:14.2f}"


def tables() -> Iterator[str]:
    """Everything, as lines of text."""
    forward, feedback = ([getattr(t, name) for t in disturbed()] for name in ("forward", "feedback"))
    yield from closed_forms()
    yield ""
    yield from estimates("Table 3: forward gain, moved by -200 ppm", TABLE_3, forward, ideal().forward, 4)
    yield ""
    yield from estimates("Table 4: N_on - N_off, moved by +200 ppm", TABLE_4, feedback, ideal().feedback, 2)
    yield ""
    yield "Fig. 13: error of the output, ug      before       after"
    yield f"paper [P]                       {FIGURE_13[0]:12.1f}{FIGURE_13[1]:12.1f}   (without sign)"
    yield f"ideal                           {ideal().errors[0]:12.1f}{ideal().errors[1]:12.1f}"
    rows = np.array([t.errors for t in disturbed()])
    mean, std = np.mean(rows, axis=0), np.std(rows, axis=0, ddof=1)
    yield f"disturbed [C], mean of six      {mean[0]:12.1f}{mean[1]:12.1f}"
    yield f"               and their std    {std[0]:12.1f}{std[1]:12.1f}"
    for bits in (16, 18, 20):
        before, after = with_converter(bits).errors
        yield f"ideal with {bits} bits in DA0       {before:12.1f}{after:12.1f}"
    yield ""
    yield "Scatter of a feedback measurement, ppm [C]"
    yield f"{'seconds':>8}{'on, off once':>15}{'on off, 5 s':>15}{'ABBA, 5 s':>15}{'white noise':>15}"
    for seconds in (20, 100, 400, 2000):
        bound = 10.0 * (2.0 / seconds) ** 0.5 * MICRO_G * -SCALE_FACTOR / (FEEDBACK_CURRENT * CODES_PER_AMPERE) / PPM
        cells = [scatter(seconds, pattern) for pattern in ("once", "chopped", "ABBA")]
        yield f"{seconds:8}" + "".join(f"{cell:15.2f}" for cell in (*cells, bound))


if __name__ == "__main__":
    print("\n".join(tables()))
