"""The sigma-delta accelerometers of the gallery: bits and decimated output of an independent program."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from scipy import signal

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Probe
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("sigma_delta_accelerometer.toml"))
RATE, TICKS = 512_000, 20_000
SECTIONS = {"second": (0.0, 0.0, 0.0, 0.0), "fourth": (-1.9705, 0.97093527, -2.0, 1.00009637)}


def bits(b1: float, b2: float, a1: float, a2: float) -> np.ndarray:
    """The one-bit output for a tone of 1 g at 105 Hz."""
    mass, damping, stiffness = 1.2e-6, 6e-3, 5.0
    a = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]]) / RATE
    (p, q, f), (r, s, g) = scipy.linalg.expm(a)[:2].tolist()
    x = v = before = s1 = s2 = 0.0
    out = []
    for n in range(TICKS):
        read = 1e7 * x
        lead = 21.0 * read - 20.0 * before
        y = lead + s1
        s1, s2 = b1 * lead - a1 * y + s2, b2 * lead - a2 * y
        bit = 1.0 if y >= 0.0 else -1.0
        force = mass * 9.80665 * math.sin(2.0 * math.pi * 105.0 * n / RATE) - mass * 3.0 * 9.80665 * bit
        x, v, before = p * x + q * v + f * force, r * x + s * v + g * force, read
        out.append(bit)
    return np.array(out)


@pytest.mark.parametrize("order", SECTIONS)
def test_bits_and_decimated_output(order: str) -> None:
    quiet = GRAPH.with_parameters({"second.temperature": 0.0, "fourth.temperature": 0.0})
    probed = replace(quiet, probes=(Probe(f"{order}.sign"), Probe(f"{order}.output")))
    result = simulate(probed, samples=TICKS, engine="compiled")
    expected = bits(*SECTIONS[order])
    assert (result[f"{order}.sign"].values == expected).all()
    comb = signal.convolve(signal.convolve(np.ones(64), np.ones(64)), np.ones(64)) / 64.0**3
    slow = np.concatenate([[0.0], np.convolve(expected, comb)])[:TICKS:64]
    taps = signal.firwin(64, 0.2, window=("kaiser", 8.0))
    filtered = np.concatenate([[0.0], np.convolve(slow, taps)])[: len(slow) : 4]
    assert result[f"{order}.output"].values == pytest.approx(3.0 * 9.80665 * filtered, abs=1e-11)


@pytest.mark.exhaustive
def test_noise_of_the_second_and_the_fourth_order() -> None:
    """What is left of the tone's fit up to 600 Hz: shaped noise, and behind the fourth order that of the gas alone."""
    result = simulate(GRAPH, duration="1.1 s", engine="compiled")
    left = {}
    for order in SECTIONS:
        values = result[f"{order}.output"].values[200:2200]
        t = np.arange(len(values)) / 2000.0
        window = signal.windows.blackmanharris(len(values))
        terms = np.column_stack([np.ones_like(t), np.sin(2.0 * np.pi * 105.0 * t), np.cos(2.0 * np.pi * 105.0 * t)])
        rest = values - terms @ np.linalg.lstsq(terms, values, rcond=None)[0]
        density = 2.0 * np.abs(np.fft.rfft(rest * window)) ** 2 / (2000.0 * np.sum(window**2))
        left[order] = math.sqrt(np.mean(density[5:301]))  # up to 300 Hz
    gas = math.sqrt(4.0 * 1.380649e-23 * 300.0 * 6e-3) / 1.2e-6
    assert left["fourth"] == pytest.approx(gas, rel=0.15)
    assert left["second"] > 1.2 * left["fourth"]
