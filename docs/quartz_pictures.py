"""Fig. 11 to 13 of Ran et al. 2019 drawn again from the graphs of the library, into docs/pictures.

python -m docs.quartz_pictures
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from docs.quartz_accelerometer import MICRO_G, SCALE_FACTOR, TABLE_4, disturbed, library, run
from proofmass.blocks.decimator import Decimator
from proofmass.graphs.graph import Graph
from proofmass.runner.engine.simulate import simulate
from proofmass.runner.output.plot import BLUE, ORANGE, write_figure

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


def main() -> None:
    """Draw all three beside each other."""
    figure = Figure(figsize=(11.0, 3.2), layout="constrained")
    for draw, axes in zip((figure_11, figure_12, figure_13), figure.subplots(1, 3), strict=True):
        draw(axes)
        axes.title.set_fontsize(9)
        axes.ticklabel_format(useOffset=False)
    with (Path(__file__).parent / "pictures" / "quartz_calibration.svg").open("wb") as file:
        write_figure(figure, file, "svg", **{"svg.fonttype": "none"})


if __name__ == "__main__":
    main()
