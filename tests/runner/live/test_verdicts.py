"""Verdicts and tabs of a live page: about the run that it shows, and the operating point that the commands take."""

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.runner.live.model import live_model
from proofmass.runner.live.session import Session, read_state
from proofmass.runner.live.verdicts import verdicts

GROWING = """
name = "a gain that grows from 150 to 1500 in a second"
rate = "1 kHz"
duration = "2 s"
wires = [
    "goal.output -> error.first", "back.output -> error.second", "error.output -> gain.first",
    "base.output -> grown.first", "growth.output -> low.input", "low.output -> grown.second",
    "grown.output -> gain.second", "gain.output -> integral.input", "integral.output -> back.input",
]
loops.main = { open_at = "integral.output", gain_margin = "20 dB" }
[blocks]
goal = { kind = "Constant", value = 1 }
base = { kind = "Constant", value = 0.1 }
growth = { kind = "Constant", value = 0.9 }
low = { kind = "LowPass", corner_frequency = 10 }
grown = { kind = "Sum" }
error = { kind = "Sum" }
gain = { kind = "Product" }
back = { kind = "Negation" }
integral = { kind = "DiscreteIntegrator", gain = 1500, output_unit = "1" }
"""


@pytest.mark.defect("S998", before="stable, 22.50 dB: met, where margins tells 2.50 dB", after="2.50 dB: missed")
def test_a_loop_is_judged_where_it_settles() -> None:
    """An integrator of gain k has 20 log10(2 / (k T)) dB: 2.5 dB with k = 1500 / s, 22.5 dB at the start."""
    graph = read_graph_text(GROWING)
    quick, thorough = verdicts(graph, thorough=False), verdicts(graph, thorough=True)
    assert quick.verdicts[0]["value"].startswith(f"stable, {20.0 * math.log10(2.0 / 0.15):.2f} dB")
    assert quick.verdicts[0]["value"].endswith("at the start")
    assert quick.more
    loop, limit = thorough.verdicts
    assert f"stable, {20.0 * math.log10(2.0 / 1.5):.2f} dB" in loop["value"]
    assert limit["met"] is False


NOISY = """
name = "noise"
rate = "1 kHz"
duration = "0.1 s"
probes = ["noise.output"]
blocks.noise = { kind = "WhiteNoise", density = 1.0 }
"""


@pytest.mark.defect(
    "S999", before="the spectrum of the file's 101 values and seed", after="that of the page's 1,001 values"
)
def test_a_spectrum_is_that_of_the_run_that_a_page_shows(tmp_path: Path) -> None:
    (tmp_path / "noise.toml").write_text(NOISY)
    session = Session(tmp_path / "noise.toml", lambda: read_graph(tmp_path / "noise.toml"))
    assert session.reload() == []
    texts = []
    for seed in ("1", "2"):
        answer = session.answer("spectra", {"state": {"values": {}, "seed": seed, "duration": "1 s"}})
        assert answer is not None
        texts.append(answer["text"])
    assert texts[0].startswith("noise.output: 1,001 values")
    assert texts[0] != texts[1]


@pytest.mark.parametrize("length", ["samples = 11", 'duration = "1/300 s"'])
@pytest.mark.defect("S1000", before="10 ticks of 11, or tabs without an answer", after="all ticks")
def test_the_length_of_a_run_is_told_as_a_decimal_that_is_no_tick_shorter(length: str) -> None:
    ramp = 'rate = "3 kHz"\nprobes = ["ramp.output"]\nblocks.ramp = { kind = "Ramp" }\n'
    model = live_model(read_graph_text(f"{length}\n{ramp}"))
    assert read_state({"state": {"values": {}, "seed": "0", "duration": model["duration"]}}) is not None
    assert np.floor(float(Fraction(model["duration"].removesuffix(" s")) * 3000)) + 1 == 11
