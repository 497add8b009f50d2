"""The claims of Liu, Li and Shen on temperature compensation, in the order of the paper."""

import math
from functools import partial

import numpy as np

from docs.papers import compensators
from docs.papers.claim import Claim
from proofmass.blocks import FixedCordicExponential, FixedQuantiser, FixedRangeReducer, Ramp
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.graphs.model.build import Graph
from proofmass.runner.rtl.tools.synth import ChipFamily
from proofmass.runner.run.simulate import simulate

M1, POLYNOMIAL, CIRCUIT = (
    "temperature_compensation_m1",
    "temperature_compensation_polynomial",
    "temperature_compensator",
)
SETS = "its readings are lost; ours are made so that the peak-to-peak values come out"
LOST = "its table is lost, and no readings are given"


def rmse(device: str) -> str:
    """Of two exponentials, third and fourth order."""
    fits = compensators.fitted(device).fits
    return " / ".join(f"{1e6 * fits[number].rmse:.2f}" for number in (0, 2, 3)) + " uV"


def iterations() -> str:
    """Of both methods, on M1; where the slow one ends to a few iterations follows from the last digits of a machine."""
    projection, alternation = compensators.fitted("m1").fits[:2]
    return f"some {round(alternation.iterations, -2):,}, by variable projection {projection.iterations}; the same RMSE"


def core(bits: int = 16) -> str:
    """Largest relative error of the rotations, over every angle of [0, ln 2) of so many bits."""
    steps = math.floor(math.log(2.0) * 2**bits)
    graph = Graph(
        name="every angle",
        rate=1,
        blocks={
            "angle": Ramp(slope=2.0**-bits, unit="1"),
            "word": FixedQuantiser(output_format=Fixed(bits, bits, signed=False)),
            "rotations": FixedCordicExponential(fraction_bits=bits, iterations=bits),
        },
        wires=["angle.output -> word.input", "word.output -> rotations.angle"],
        probes=["rotations.exponential"],
        samples=steps,
    )
    found = simulate(graph, engine="compiled")["rotations.exponential"].values
    exact = np.exp(np.arange(steps) * 2.0**-bits)
    return f"{100.0 * np.abs(found / exact - 1.0).max():.5f} %"


def reach() -> str:
    """Sum of the angles of the rotations, 4 and 13 twice, over ln 2."""
    total = sum(math.atanh(2.0**-i) * (2 if i in (4, 13) else 1) for i in range(1, 17))
    return f"{total:.3f} of a needed {math.log(2.0):.3f}"


def product_bits() -> str:
    """Signed bits of the largest product of an exponent in [-2^6, 2^6) with 2^16 / ln 2."""
    largest = 2**22 * round(2**16 / math.log(2.0))
    return f"{largest.bit_length() + 1} bits of 2M + N + 3 = {FixedRangeReducer().fraction_bits * 2 + 6 + 3}"


def left(device: str, name: str = "exponentials") -> str:
    """Peak to peak before and after, in registers."""
    _, _, rest = compensators.compensated(device, name)
    return f"{1e3 * compensators.fitted(device).before:.4f} to {1e3 * float(np.ptp(rest)):.4f} mV"


def orders_of_magnitude() -> str:
    """Reduction of both devices."""
    cells = []
    for device in ("m1", "m2"):
        rest = float(np.ptp(compensators.compensated(device, "exponentials")[2]))
        cells.append(f"{compensators.fitted(device).before / rest:.1f}")
    return " and ".join(cells) + " times less"


def relative_error() -> str:
    """Largest of M2 over the 61 temperatures, relative and absolute, against the function at the word of each."""
    temperature, value, _ = compensators.compensated("m2", "exponentials")
    words = np.round(temperature * 65536.0) / 65536.0
    exact = compensators.fitted_function("m2", False, words)
    relative, absolute = np.abs(value / exact - 1.0).max(), np.abs(value - exact).max()
    return f"{100.0 * relative:.3f} %, {1e6 * absolute:.2f} uV"


def cells(name: str) -> str:
    """Slices at least, flip-flops, lookup tables and multipliers of a Virtex-II Pro."""
    r = compensators.resources(name, "xc2vp")
    return f"{r.slices_bound} / {r.flip_flops} / {r.luts} / {r.multipliers}"


def both_cells() -> str:
    """Pipelined exponentials, and the pipelined polynomial."""
    return f"{cells('exponentials, pipelined')}; polynomial {cells('polynomial, pipelined')}"


def both_clocks(family: ChipFamily) -> str:
    """Of the same."""
    found = (compensators.resources(f"{name}, pipelined", family) for name in ("exponentials", "polynomial"))
    first, second = (f"{r.clock.megahertz:.0f} MHz" if r.clock.megahertz else "not placed" for r in found)
    return f"{first}; polynomial {second}"


CLAIMS = (
    Claim("temperature-sensors", "1", "temperature is what limits accuracy; other methods are hard to integrate",
          "in words", "open", "a judgement on other works"),
    Claim("temperature-eq-1", "1, eq. 1, Fig. 3", "two exponentials fit the zero bias of M1 and M2", "curves",
          "holds", SETS,
          M1, partial(left, "m1")),
    Claim("temperature-alternation", "1, eq. 2, 3", "alternation lowers the work of choosing starts", "in words",
          "differs",
          "steps 3 and 4 are lost; it arrives from nearly all starts, but slowly", "zero_bias_m1.csv", iterations),
    Claim("temperature-eq-5", "2, eq. 4, 5", "rotations from 1/K give the exponential", "an equation", "holds",
          "number of iterations and rounding are not said; 16 here", CIRCUIT, core),
    Claim("temperature-eq-6", "2, eq. 6", "a remainder below ln 2 is within reach", "in words", "holds",
          "with rotations 4 and 13 done twice", CIRCUIT, reach),
    Claim("temperature-eq-8", "2, eq. 7 to 9, Fig. 2", "A has 2M + N + 3 bits; two multipliers reduce any exponent",
          "2M + N + 3",
          "holds", "the width of its two words together; its range takes a bit less", CIRCUIT, product_bits),
    Claim("temperature-range", "2", "exponents in [-2^N, 2^N)", "any", "fails",
          "exp(64) has 93 bits before the point; it saturates, and of exp(-64) no bit is left", CIRCUIT),
    Claim("temperature-eq-10", "3, eq. 10", "coefficients of M1 and M2", "lost", "open", LOST),
    Claim("temperature-table-1", "3, Table 1", "M1: RMSE of two exponentials / third / fourth order", "lost", "open",
          SETS, "zero_bias_m1.csv", partial(rmse, "m1")),
    Claim("temperature-table-2", "3, Table 2", "M2: the same", "lost", "open", SETS, "zero_bias_m2.csv", partial(rmse,
          "m2")),
    Claim("temperature-order", "3", "two exponentials are as accurate as fourth order and above", "in words", "holds",
          "on these sets; for M2 by 2 % of the rest only", POLYNOMIAL,
          lambda: f"{left('m2')}; polynomial {left('m2', 'polynomial')}"),
    Claim("temperature-table-3", "3, Table 3", "largest relative error of M2 with 2^16", "0.019 %", "differs",
          "ours has 24 bits at the output; 16 cannot reach 0.019 % of less than 6 mV, but of 1.3 V", CIRCUIT,
          relative_error),
    Claim("temperature-m1", "3, Fig. 4", "M1 from 0.0039 V", "0.36871 mV", "holds", SETS, POLYNOMIAL, partial(left,
          "m1")),
    Claim("temperature-m2", "3, Fig. 4", "M2 from 0.0019 V", "0.18413 mV", "holds", SETS, POLYNOMIAL, partial(left,
          "m2")),
    Claim("temperature-decade", "3, 4", "an order of magnitude less", "10 times", "holds", SETS, POLYNOMIAL,
          orders_of_magnitude),
    Claim("temperature-multipliers", "3", "three multipliers and one rotation algorithm a term", "3", "holds",
          "with the factor preloaded; of 18 by 18 bits it is ten for both terms, since a word is longer than one",
          "exponential_term_preloaded", lambda: cells("exponentials, factors preloaded"), slow=True),
    Claim("temperature-area", "3", "less area than a polynomial of fourth order", "in words", "fails",
          "Horner's rule takes four products; the rotations alone take thousands of lookup tables",
          POLYNOMIAL, both_cells, slow=True),
    Claim("temperature-speed", "3", "faster than a polynomial of fourth order", "in words", "fails",
          "an estimate for a Virtex-II Pro; both take a temperature in every tick, 22 and 8 ticks late", POLYNOMIAL,
          partial(both_clocks, "xc2vp"), slow=True),
    Claim("temperature-words", "2, 3", "larger words are more accurate", "in words", "holds",
          "the rotations with 20 bits; with 16 it is 0.01373 %", CIRCUIT, partial(core, 20), slow=True),
    Claim("temperature-figure-1", "Fig. 1", "memory, two terms, a difference", "a drawing", "holds", "", CIRCUIT,
          partial(left, "m2")),
)  # fmt: skip
