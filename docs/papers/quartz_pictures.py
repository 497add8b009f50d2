"""Pictures of the digital quartz accelerometer, into docs/pictures.

    python -m docs.papers.quartz_pictures [FOLDER]

Fig. 11 to 13 of Ran et al. 2019 drawn again, and ten years of drift. FOLDER is that of
`proofmass montecarlo quartz_recalibration_study.toml --out FOLDER`; without it the study is run, for some minutes.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from docs.papers.quartz_accelerometer import MICRO_G, PPM, SCALE_FACTOR, TABLE_4, disturbed, library, run, study
from proofmass.blocks import Decimator
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.ages import YEAR, recalibration_text
from proofmass.runner.output.pictures import BLUE, ORANGE, write_figure
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.shown.points import by_point
from proofmass.runner.studies.whole.study import run_study

GREEN = "#009e73"
MEAN = 12_500  # ticks of a point of Fig. 13: a quarter of a second


def figure_11(axes: Any) -> None:
    """Responses of the swept bridge, and what the second sweep takes off the first."""
    result = run("quartz_forward_gain")
    numbers, means = result["sweep.number"].values, result["average.mean"].values
    ends = np.flatnonzero(np.diff(numbers)) + 1  # the mean of a slot is there when the next begins
    swept = numbers[ends - 1] < 20_000.0
    numbers, means = numbers[ends - 1][swept], means[ends][swept]
    axes.plot(numbers[:11], means[11:] - means[:11], "o-", color=ORANGE, markersize=3)
    axes.set(xlabel="N_FPGA", ylabel="change of N_out [codes]", title="Fig. 11: forward gain, -200 ppm (ideal)")


def figure_12(axes: Any) -> None:
    """N_on - N_off of six trials."""
    trials = range(1, 7)
    for rows, marker, name in (([t.feedback for t in disturbed()], "x", "graph [C]"), (TABLE_4, "o", "paper [P]")):
        for column, color, when in ((0, BLUE, "before"), (1, ORANGE, "after")):
            values = [row[column] for row in rows]
            axes.plot(trials, values, marker, color=color, fillstyle="none", markersize=5, label=f"{when}, {name}")
    axes.set(xlabel="trial", ylabel="N_on - N_off [codes]", title="Fig. 12: feedback gain, +200 ppm")
    axes.legend(fontsize=7, loc="center right")


def figure_13(axes: Any) -> None:
    """Outputs of the three static tests of the first disturbed trial, as means over a quarter of a second."""
    trial = library("quartz_calibration_disturbed").with_parameters({"sensor.test_slots.averaging": 5.0})
    graph = Graph(
        name="static tests",
        blocks={"trial": trial, "mean": Decimator(ratio=MEAN)},
        wires=["trial.sensor.accelerometer.number -> mean.input"],
        probes=["mean.mean", {"signal": "trial.sensor.sequencer.step", "every": MEAN}],
        rate=trial.rate,
    )
    result = simulate(graph, duration=trial.duration, seed=1, engine="compiled")
    outputs, steps = result["mean.mean"].values, result["trial.sensor.sequencer.step"].values
    reference = np.nan
    for step, color, name in ((2, BLUE, "N(0)"), (3, ORANGE, "N'(1), drifted"), (6, GREEN, "N(1), compensated")):
        rows = np.flatnonzero(steps == step)[3:]  # past what switching left in the first means
        points = outputs[rows] / SCALE_FACTOR / MICRO_G
        reference = points.mean() if step == 2 else reference
        axes.plot(0.25 * np.arange(len(rows)), points - reference, ".-", color=color, linewidth=0.8, label=name)
    axes.set(xlabel="time in the test [s]", ylabel="output less mean N(0) [ug]", title="Fig. 13: one trial [C]")
    axes.legend(fontsize=7)


def ten_years(folder: str | None, panels: Any) -> None:
    """Fans of scale factor, bias and gain margin: never calibrated again, every year, every month."""
    result = run_study(study("quartz_recalibration_study"), folder=folder)
    ages = np.array(result.study.epochs) / YEAR
    parts = zip(result.study.recalibration.every, by_point(result), (BLUE, ORANGE, GREEN), strict=True)
    for interval, part, color in parts:
        scale = part["scale_factor"] / part["scale_factor"][:, :1] - 1.0
        drawn = (scale / PPM, part["bias"] / MICRO_G, part["main.gain_margin"])
        for axes, values in zip(panels, drawn, strict=True):
            for low, high, strength in ((0.0, 100.0, 0.25), (25.0, 75.0, 0.35)):
                edges = np.percentile(values, (low, high), axis=0)
                axes.fill_between(ages, *edges, color=color, alpha=strength, linewidth=0.0)
            axes.plot(ages, np.median(values, axis=0), color=color, linewidth=0.9, label=recalibration_text(interval))
    titles = (("scale factor as found", "change [ppm]"), ("bias as found", "bias [ug]"), ("gain margin", "[dB]"))
    for axes, (title, label) in zip(panels, titles, strict=True):
        axes.set(title=f"{title}, {len(result.numbers) // 3} sensors [A]", xlabel="age [years]", ylabel=label)
    panels[0].legend(fontsize=7)


def save(figure: Figure, name: str) -> None:
    """Write a picture of the docs."""
    for axes in figure.axes:
        axes.title.set_fontsize(9)
        axes.ticklabel_format(useOffset=False)
    with (Path(__file__).parents[1] / "pictures" / f"{name}.svg").open("wb") as file:
        write_figure(figure, file, "svg", **{"svg.fonttype": "none"})


def main(folder: str | None = None) -> None:
    """Draw both pictures, three panels beside each other in each."""
    figure = Figure(figsize=(11.0, 3.2), layout="constrained")
    for draw, axes in zip((figure_11, figure_12, figure_13), figure.subplots(1, 3), strict=True):
        draw(axes)
    save(figure, "quartz_calibration")
    figure = Figure(figsize=(11.0, 3.2), layout="constrained")
    ten_years(folder, figure.subplots(1, 3))
    save(figure, "quartz_recalibration")


if __name__ == "__main__":
    main(*sys.argv[1:2])
