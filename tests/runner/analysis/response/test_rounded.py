"""Peaks of responses whose maps do not carry the digits that are shown, against the closed form."""

import math
import re

import pytest

from proofmass import response
from proofmass.graphs.files.toml_reader import read_graph_text

RESONATOR = """
name = "a resonator"
rate = "{rate} Hz"
samples = 8
wires = ["kick.output -> mass.force"]
probes = ["mass.displacement"]
[blocks.kick]
kind = "Step"
unit = "N"
[blocks.mass]
kind = "MassSpringDamper"
mass = "1 kg"
damping = "{damping} N*s/m"
stiffness = "{stiffness} N/m"
"""
TURN = 2.0 * math.pi  # rad/s: a resonance of 1 Hz


def told_and_off(rate: float, quality: float) -> tuple[list[str], float]:
    """Return the note, and by what part the peak is off: it is Q / K, but for 1 / (8 Q^2) and (w T)^2 / 24."""
    text = RESONATOR.format(rate=rate, damping=repr(TURN / quality), stiffness=repr(TURN**2))
    found = response(read_graph_text(text), "kick.output", "mass.displacement")
    notes = [note for note in found.notes if note.startswith("figures are")]
    return notes, abs(found.peak[1] / (quality / TURN**2) - 1.0)


@pytest.mark.defect("H889", before="a peak 0.15 % off, with five digits", after="known to 0.2 % only")
@pytest.mark.exhaustive("100000000.0")
@pytest.mark.parametrize(("rate", "quality"), [(1e5, 1e7), (1e5, 1e8), (1e5, 1e9)])
def test_a_peak_is_as_well_known_as_is_told(rate: float, quality: float) -> None:
    (note,), off = told_and_off(rate, quality)
    (told,) = re.findall(r"known to ([\d.e-]+) % only", note)
    assert 1e-5 < off < float(told) / 100.0
    assert float(told) / 100.0 < 10.0 * 2.0**-53 / (math.pi / rate / quality)


def test_a_peak_that_no_digit_carries_is_not_known() -> None:
    """Half a last digit of a number below one is 5.6e-17, and 1 - |p| here 3.1e-15; some numbers off make it grow."""
    (note,), off = told_and_off(1e6, 1e9)
    assert off > 0.01
    assert note.startswith("figures are not known: a mode is 3e-15")


def test_a_peak_of_a_mode_that_decays_has_no_note() -> None:
    notes, off = told_and_off(1e4, 1e4)
    assert notes == []
    assert off < 1e-6
