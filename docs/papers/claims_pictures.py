"""Pictures of the page of claims, into docs/pictures.

python -m docs.papers.claims_pictures
"""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from docs.papers import compensators, half_power, pn_findings, quartz_findings
from docs.papers.claim import VERDICTS
from docs.papers.claims import PAPERS
from docs.papers.pn_runs import GYROSCOPE
from proofmass.runner.output.pictures import BLUE, GREEN, ORANGE, save_figure

PICTURES = Path(__file__).parents[1] / "pictures"
GREY = "#bbbbbb"


def verdicts(axes: Any) -> None:
    """How many claims have which verdict."""
    begin = np.zeros(len(PAPERS))
    for verdict, color in zip(VERDICTS, (BLUE, GREEN, ORANGE, GREY), strict=True):
        numbers = np.array([Counter(c.verdict for c in claims)[verdict] for claims in PAPERS.values()])
        axes.barh(range(len(PAPERS)), numbers, left=begin, color=color, label=verdict)
        begin = begin + numbers
    axes.set(title="claims by verdict", yticks=range(len(PAPERS)), ylim=(2.5, -1.2))
    axes.set_yticklabels(["self-\ncalibration", "quartz", "temperature"])
    axes.legend(ncols=4, loc="upper center", handlelength=0.8, columnspacing=0.8)


def half_powers(axes: Any) -> None:
    """The swept response of the gyroscope's sense mode, and both frequencies of half the power."""
    swept, fine = half_power.SWEEP, np.linspace(half_power.SWEEP[0], half_power.SWEEP[-1], 400)
    response = half_power.amplitudes(swept)[0]
    w, force = 2.0 * np.pi * fine, 2.0 * 14.757e-9 * 15.0 * 0.2
    exact = np.abs(force / (GYROSCOPE.stiffness - GYROSCOPE.mass * w**2 + 1j * w * GYROSCOPE.damping))
    held = np.sinc(fine / 1e5)  # the sine is held over 10 us
    axes.plot(1e-3 * fine, GYROSCOPE.readout * held * exact, color=GREY, label="closed form")
    axes.plot(1e-3 * swept, response, "o", color=BLUE, fillstyle="none", markersize=4, label="graph, 5 mV")
    found = half_power.half_power(swept, response, GYROSCOPE.mass)
    middle = np.sqrt(found.stiffness / GYROSCOPE.mass) / (2.0 * np.pi)
    width = found.damping / (2.0 * np.pi * GYROSCOPE.mass)
    level = float(response.max()) / np.sqrt(2.0)
    axes.plot(1e-3 * np.array([middle - width / 2, middle + width / 2]), [level, level], ".-", color=ORANGE,
              label=f"half power: {width:.1f} Hz")  # fmt: skip
    axes.set(title="damping by half power", xlabel="frequency [kHz]", ylabel="[V]", ylim=(0.0, None))
    axes.legend(loc="lower center")


def tuning(axes: Any) -> None:
    """What the voltage of the sense plates does to the gyroscope."""
    volts = np.array([0.0, 1.5, 3.0, 4.0, 4.75, 5.25, 5.5, 5.76, 6.0, 6.25, 6.75, 7.5])
    moved = [1e18 * pn_findings.measured("capacitance_amplitude", float(v)) for v in volts]
    axes.plot(volts, moved, "o-", color=BLUE, markersize=4)
    axes.set(title="gyroscope at 1 deg/s", xlabel="voltage on the sense plates [V]", ylabel="capacitance [aF]")


def trials(axes: Any) -> None:
    """What compensation leaves in 100 trials of the quartz accelerometer."""
    before, after = quartz_findings.hundred()
    axes.hist(100.0 * (1.0 - np.abs(after) / np.abs(before)), bins=20, color=BLUE)
    axes.axvline(100.0 * quartz_findings.RESTORED, color=ORANGE, label="paper, 87.56 %")
    axes.set(title="quartz: error removed, 100 trials", xlabel="[%]", ylabel="trials")
    axes.legend()


def remains(axes: Any) -> None:
    """What both compensators leave of M1."""
    for name, color in (("exponentials", BLUE), ("polynomial", ORANGE)):
        temperature, value, _ = compensators.compensated("m1", name)
        fit = compensators.fitted("m1")
        law = compensators.fitted_function("m1", False, temperature)
        axes.plot(temperature, 1e6 * (law - value), ".-", color=color, markersize=3, label=name)
    axes.plot(temperature, 1e6 * (fit.readings.output - law), ".", color=GREY, markersize=3, label="readings")
    axes.set(title="M1: distance from two exponentials", xlabel="sensor [V]", ylabel="[uV]")
    axes.legend()


def hardware(axes: Any) -> None:
    """Lookup tables and clock of both, pipelined, over those of the polynomial."""
    first, second = (compensators.resources(f"{name}, pipelined", "xc2vp") for name in ("exponentials", "polynomial"))
    pairs = [(r.luts, r.flip_flops, r.multipliers, r.clock.megahertz or 0.0) for r in (first, second)]
    shares = np.array(pairs[0]) / np.array(pairs[1])
    axes.bar(["LUT", "FF", "MULT", "clock"], shares, color=[BLUE, BLUE, BLUE, ORANGE])
    axes.axhline(1.0, color="black", linewidth=0.8)
    for place, share in enumerate(shares):
        axes.annotate(f"{share:.2g}", (place, share), ha="center", va="bottom")
    axes.set(title="exponentials over polynomial", ylabel="times", yscale="log", ylim=(0.3, 15.0))


def picture() -> Figure:
    """Claims by verdict, and what is new in them."""
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    panels = figure.subplots(2, 3).flat
    for panel, draw in zip(panels, (verdicts, half_powers, tuning, trials, remains, hardware), strict=True):
        draw(panel)
    return figure


def main() -> None:
    """Draw it."""
    save_figure(picture(), PICTURES / "papers_claims.png")


if __name__ == "__main__":
    main()
