"""The digital half of Liu, Li and Shen's compensation: the library's graphs against plain integers, and its errors.

What `cordic_by_hand.chain` computes is shown to be what the graphs compute, bit by bit, and where words have other
lengths than theirs, what their blocks compute.
"""

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import (
    FixedCordicExponential,
    FixedCordicScaledExponential,
    FixedOctaveShift,
    FixedProduct,
    FixedRangeReducer,
    Ramp,
)
from proofmass.blocks.arithmetic.cordic import hyperbolic_growth
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.graphs.files.library import FOLDER, library_file
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.design.fit.fit import fit
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate
from tests.by_hand.cordic import chain, growth, scaled, swept
from tests.by_hand.temperature_sets import DEVICES, TEMPERATURE


@cache
def law_of(name: str) -> Mapping[str, float]:
    return fit(DEVICES[name].readings(), [], tolerance=1.0).fits[0].values


each = pytest.mark.parametrize("name", DEVICES)


def predicted(name: str, volts: Any, further: int, preload: bool = False, bits: int = 16) -> tuple[Any, Any]:
    """The sum of both terms in volts, by the blocks, and what it should be at the quantised temperatures.

    The numbers are those of plain integers, which the blocks are held against bit by bit.
    """
    law, words = law_of(name), np.round(volts * 2.0**bits).astype(np.int64)
    pairs = (law["a1"], law["b1"]), (law["a2"], law["b2"])
    terms = [chain(words, a, b, bits, further, preload) for a, b in pairs]
    for (a, b), term in zip(pairs, terms, strict=True):
        if bits < 24:  # beyond it a product is of more than 64 bits
            assert np.array_equal(chain_of_blocks(words, a, b, bits, further, preload), term)
    found = sum(terms)
    return found * 2.0 ** -(bits + further), sum(a * np.exp(b * words * 2.0**-bits) for a, b in pairs)


def chain_of_blocks(words: Any, a: float, b: float, bits: int, further: int, preload: bool = False) -> Any:
    """a exp(b T) by the blocks of the library's graphs one after the other, with words of other lengths."""
    whole = max(0, math.ceil(math.log2(abs(a)))) + 1
    exponent_format, factor_format = Fixed(bits + 7, bits), Fixed(bits + further + whole, bits + further)
    product = FixedProduct(
        first_format=Fixed(bits + 5, bits),
        second_format=Fixed(bits + 2, bits),
        output_format=exponent_format,
        rounding="floor",
    )
    exponents = swept(product, "output", np.full(len(words), scaled(b, bits)), words)
    reducer = FixedRangeReducer(fraction_bits=bits)
    octaves, angles = (swept(reducer, name, exponents) for name in ("octave", "remainder"))
    unsigned = Fixed(bits + 2, bits, signed=False)
    if preload:
        rotations = FixedCordicScaledExponential(fraction_bits=bits, iterations=bits, preloaded_format=factor_format)
        grown = swept(rotations, "output", angles, np.full(len(words), scaled(a / growth(bits), bits + further)))
        wide = Fixed(factor_format.width + 2, bits + further)
        return swept(FixedOctaveShift(input_format=wide, output_format=wide), "output", grown, octaves)
    turned = swept(FixedCordicExponential(fraction_bits=bits, iterations=bits), "exponential", angles)
    shift = FixedOctaveShift(input_format=unsigned, output_format=Fixed(bits + 12, bits))
    shifted = swept(shift, "output", turned, octaves)
    scaling = FixedProduct(
        first_format=factor_format,
        second_format=Fixed(bits + 12, bits),
        output_format=Fixed(factor_format.width + 3, bits + further),
        rounding="floor",
    )
    return swept(scaling, "output", np.full(len(words), scaled(a, bits + further)), shifted)


def errors(name: str, further: int, preload: bool = False, bits: int = 16) -> tuple[float, float]:
    """Largest error over the temperatures of the table: relative in percent, absolute in volts."""
    found, exact = predicted(name, TEMPERATURE, further, preload, bits)
    return 100.0 * float(np.max(np.abs(found / exact - 1.0))), float(np.max(np.abs(found - exact)))


def compensator(name: str, term: str = "exponential_term") -> Graph:
    """The compensator of the library with the coefficients of a device, over a ramp of its temperature."""
    text, changes = library_file("temperature_compensator.toml").read_text(encoding="utf-8"), dict(law_of(name))
    text = text.replace("exponential_term.toml", f"{term}.toml")
    if term == "exponential_term_preloaded":
        changes["memory.growth"] = hyperbolic_growth(16)
    digital = read_graph_text(text, folder=str(FOLDER / "parts")).with_parameters(changes)
    sources = {"warming": Ramp(offset=0.6, slope=1.2, unit="V"), "bias": Ramp(offset=0.006, slope=-0.004, unit="V")}
    return Graph(
        name="a ramp of the temperature",
        rate=500,
        blocks={**sources, "digital": digital},
        wires=["warming.output -> digital.temperature", "bias.output -> digital.sensor"],
        probes=["digital.temperature.output", "digital.sensor.output", "digital.value", "digital.compensated"],
    )


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.parametrize("preload", [False, True])
@each
def test_the_graphs_are_the_plain_integers(name: str, preload: bool, engine: EngineName) -> None:
    term = "exponential_term_preloaded" if preload else "exponential_term"
    result, law = simulate(compensator(name, term), samples=501, engine=engine), law_of(name)
    volts = result["digital.temperature.output"].mantissas
    first, second = (chain(volts, law[a], law[b], 16, 8, preload) for a, b in (("a1", "b1"), ("a2", "b2")))
    assert (volts[0], volts[-1]) == (round(0.6 * 65536), round(1.8 * 65536))
    assert np.array_equal(result["digital.value"].mantissas, first + second)
    left = result["digital.sensor.output"].mantissas - first - second
    assert np.array_equal(result["digital.compensated"].values, left * 2.0**-24)
    assert result.overflows == {} or not any(result.overflows.values())


@each
def test_the_pipelined_evaluator_gives_the_same_bits_22_ticks_later(name: str) -> None:
    """Registers behind four operations and 18 rotations, all zero in the first tick."""
    at_once, pipelined = (
        simulate(compensator(name, term), samples=501)["digital.value"].mantissas
        for term in ("exponential_term", "exponential_term_pipelined")
    )
    assert len(set(at_once.tolist())) > 400
    assert pipelined[22:].tolist() == at_once[:-22].tolist()
    assert not pipelined[:20].any()  # the last two are what the zeros before and behind the reduction lead to


@pytest.mark.parametrize(
    ("name", "further", "preload", "percent", "volts"),
    [
        ("m1", 0, False, 1.504, 34.1e-6),
        ("m1", 0, True, 12.03, 501e-6),
        ("m1", 8, False, 0.1129, 2.54e-6),
        ("m1", 8, True, 0.0796, 2.77e-6),
        ("m2", 0, False, 28.79, 247e-6),
        ("m2", 0, True, 100.4, 772e-6),
        ("m2", 8, False, 0.0359, 0.324e-6),
        ("m2", 8, True, 0.522, 4.33e-6),
    ],
)
def test_relative_and_absolute_error(name: str, further: int, preload: bool, percent: float, volts: float) -> None:
    """Output in 2^16 and in 2^24 steps a volt, factor multiplied and preloaded."""
    assert errors(name, further, preload) == pytest.approx((percent, volts), rel=5e-3)


@each
def test_eight_further_bits_compensate_as_floating_point_does(name: str) -> None:
    device = DEVICES[name]
    left = {further: float(np.ptp(device.output() - predicted(name, TEMPERATURE, further)[0])) for further in (0, 8)}
    assert left[8] == pytest.approx(device.after, rel=1e-3)
    assert abs(left[0] / device.after - 1.0) > 9e-3


@pytest.mark.parametrize(("level", "percent"), [(0.72, 0.034), (1.0, 0.025), (1.3, 0.019), (1.65, 0.015)])
def test_where_the_paper_has_its_largest_relative_error(level: float, percent: float) -> None:
    """0.019 % of M2 at 2^16 is the 0.25 mV found here, of a zero bias of 1.3 V: more than the 0.18 mV compensated to.

    A conjecture: the paper's table 3 and the level of its output are lost.
    """
    found, exact = predicted("m2", TEMPERATURE, 0)
    assert 100.0 * np.max(np.abs(found - exact)) / level == pytest.approx(percent, abs=6e-4)
    assert np.max(np.abs(found - exact)) > DEVICES["m2"].after


@pytest.mark.parametrize(
    ("level", "percent"),
    [(0.0019, (28.8, 0.0359)), (0.03, (0.512, 0.0356)), (0.1, (0.126, 0.0360)), (1.3, (0.0550, 0.0361))],
)
def test_a_larger_law_has_a_floor_of_relative_error(level: float, percent: tuple[float, float]) -> None:
    """M2 with both factors larger: with 16 bits, and with 24, the core and the range reduction are what remains."""
    law, words = law_of("m2"), np.round(TEMPERATURE * 65536).astype(np.int64)
    pairs = (law["a1"], law["b1"]), (law["a2"], law["b2"])
    exact = sum(a * np.exp(b * words / 65536) for a, b in pairs)
    times = level / exact.mean() if level > 0.0019 else 1.0
    found = [
        sum(chain_of_blocks(words, times * a, b, 16, more) for a, b in pairs) * 2.0 ** -(16 + more) for more in (0, 8)
    ]
    assert [100.0 * np.max(np.abs(f / times / exact - 1.0)) for f in found] == pytest.approx(percent, rel=5e-3)


def test_some_temperatures_as_in_the_papers_table_3() -> None:
    """Relative errors in percent of M2 with 24 bits at the output."""
    found, exact = predicted("m2", np.array([0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8]), 8)
    volts = [2.37233, 1.36979, 0.85357, 0.62109, 0.56957, 0.65523, 0.87287]
    percent = [-0.0054, -0.0096, -0.0178, -0.0205, -0.0086, 0.0006, -0.0027]
    assert 1e3 * exact == pytest.approx(volts, abs=6e-6)
    assert 100.0 * (found / exact - 1.0) == pytest.approx(percent, abs=6e-5)


@each
def test_more_bits_improve_it(name: str) -> None:
    """Enlarging the words improves the accuracy further (section 3)."""
    assert errors(name, 8, bits=20)[0] < errors(name, 8)[0] / 5.0
    assert errors(name, 8, bits=24)[0] < errors(name, 8, bits=20)[0] / 5.0
