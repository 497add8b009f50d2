"""What people read of a fit to recordings, line by line, from results that were written by hand."""

import math
from dataclasses import replace

import numpy as np

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.design.identification.fitted import Estimate, Fitted, OutputFit
from proofmass.runner.design.identification.noise_levels import NoiseLevel
from proofmass.runner.design.identification.text import fitted_text
from proofmass.runner.design.identification.whiteness import Whiteness
from tests.by_hand.design_texts import RESONATOR

MASS = Estimate("sensor.mass", "kg", 5e-8, 4.987654321e-8, 1e-11, 2.5e-11, "")
GAIN = Estimate("seen.gain", "1", 1.0, 2.5, 0.1, 0.25, "upper")
LOST = Estimate("sensor.stiffness", "N/m", 5.0, 5.123456789, math.inf, math.inf, "")
HISS = NoiseLevel("hiss.density", "V/sqrt(Hz)", 1e-3, 2.5e-3, 1e-4, "seen.output")
VOLTS = OutputFit("seen.output", "V", 1.25e-3, 1e-3, 0.98765432, Whiteness(np.array([0.01]), 0.5))
RATIO = OutputFit("ratio.output", "1", 0.5, 0.1, 0.5, Whiteness(np.array([0.75, 0.5]), 1e-9))


def fitted(**more: object) -> Fitted:
    facts = {"estimates": (MASS, GAIN, LOST), "outputs": (VOLTS, RATIO), "levels": (HISS, replace(HISS, value=None))}
    facts |= {"correlation": np.eye(3), "findings": (), "notes": (), "rows": 1200, "runs": 1, "starts": 1, "reached": 1}
    facts |= {"converged": True, "interrupted": False, "recordings": (), "modelled": (), "written": {}}
    return Fitted(read_graph_text(RESONATOR), **{**facts, **more})  # type: ignore[arg-type]


def test_every_line_of_a_fit() -> None:
    """Autocorrelations of 0.75 and 0.5 make a standard error sqrt(1 + 2.5) = 1.9 times too small."""
    correlation = np.array([[1.0, 0.9, -0.95], [0.9, 1.0, 0.89], [-0.95, 0.89, 1.0]])
    text = fitted_text(fitted(correlation=correlation, findings=("a finding",), notes=("short",)))
    assert text.splitlines() == [
        "converged; 1,200 values, 1 run",
        "",
        "parameter         before                        fitted  95% interval  unit",
        "sensor.mass        5e-08                 4.9876543e-08    +- 2.5e-11  kg",
        "seen.gain              1                           2.5       +- 0.25              at its upper bound",
        "sensor.stiffness       5                         5.123       unknown  N/m         not identifiable",
        "hiss.density       0.001                        0.0025     +- 0.0001  V/sqrt(Hz)  noise",
        "hiss.density       0.001  no more than the others make     +- 0.0001  V/sqrt(Hz)  noise",
        "",
        "output        rms left  explained  unit  what is left",
        "seen.output    0.00125  98.7654 %  V     white",
        "ratio.output       0.5  50.0000 %        not white, lag 1: +0.75; intervals are some 1.9 times too narrow",
        "",
        "a finding",
        "sensor.mass and seen.gain are correlated: +0.900",
        "sensor.mass and sensor.stiffness are correlated: -0.950",
        "note: short",
    ]


def test_how_the_search_ended() -> None:
    ends = {
        "interrupted: the best so far; 1,200 values, 7 runs": fitted(interrupted=True, runs=7),
        "did not converge; 1,200 values, 1 run": fitted(converged=False),
        "converged, 1 of 2 starts agree; 1,200 values, 1 run": fitted(starts=2),
    }
    for words, found in ends.items():
        assert fitted_text(found).splitlines()[0] == words


def test_a_little_correlation_from_one_value_to_the_next_makes_intervals_no_narrower() -> None:
    """sqrt(1 + 2 * 0.05) = 1.0488 is not 1.05 yet; sqrt(1.104) = 1.0507 is."""
    for correlation, told in ((0.05, False), (0.052, True)):
        slight = replace(RATIO, whiteness=Whiteness(np.array([correlation]), 1e-9))
        assert ("1.1 times too narrow" in fitted_text(fitted(outputs=(slight,)))) == told
