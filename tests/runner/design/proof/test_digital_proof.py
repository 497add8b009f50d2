"""Overflow and rounding of digital parts: closed forms, and all states of small sections in plain integers.

Dead bands of a first-order section: |y| <= 0.5 / (1 - |a|) in steps (Jackson, 1970). Zero-input oscillations of a
section whose register wraps: possible where |a1| + |a2| >= 1 (Ebert, Mazo and Taylor, 1969).
"""

import math
import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from proofmass import Graph
from proofmass.blocks import Constant, FixedDifference, FixedGain, FixedQuantiser, RepeatingSequence
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.design.proof.digital_proof import DigitalProof
from proofmass.runner.design.proof.prove import prove
from proofmass.runner.run.simulate import simulate
from tests.by_hand.integer_sections import Section

ROUNDINGS = ("half_even", "half_up", "floor", "toward_zero")


def overflow(graph: Graph, **ranges: Any) -> DigitalProof:
    stated = {name.replace("_", "."): limits for name, limits in ranges.items()}
    return prove(graph, no_overflow=True, input_ranges=stated).digital[0]


def rounding(graph: Graph, limit: Any = "", ends: Any = (-1, 1)) -> DigitalProof:
    ranges = {"input.output": list(ends)}
    return prove(graph, rounding={"filter.output": limit}, input_ranges=ranges).digital[0]


def errors(rule: str, parts: int) -> tuple[float, float]:
    """Return the ends of what a rule adds to multiples of 1 / parts."""
    last = 1.0 - 1.0 / parts
    near = -0.5 + 1.0 / parts if rule == "half_up" else -0.5
    return {"floor": (-last, 0.0), "toward_zero": (-last, last)}.get(rule, (near, 0.5))


@pytest.mark.parametrize("rule", ROUNDINGS)
@pytest.mark.parametrize("a", [0.5, 0.75, 0.9375, -0.9375, 0.984375])
def test_the_dead_band_of_a_first_order_section(a: float, rule: str) -> None:
    """h[n] = a^n: of its values above and below zero the sums are 1 / (1 - a), or 1 / (1 - a^2) and |a| / (1 - a^2)."""
    section = Section(64, -round(64 * a), 0, 6, 7, rule)
    found = rounding(replace(section, bits=12).graph())
    assert found.status == "proved"
    low, high = errors(rule, Fraction(a).denominator)
    up, down = (1.0 / (1.0 - a), 0.0) if a > 0.0 else (1.0 / (1.0 - a * a), -a / (1.0 - a * a))
    assert found.error == pytest.approx((up * low - down * high, up * high - down * low), rel=1e-9, abs=1e-6)
    truth = section.largest_limit_cycle()
    assert truth <= found.limit
    if rule == "half_up" and a > 0.0:
        assert truth == math.floor(0.5 / (1.0 - a)) == math.floor(found.limit)


@pytest.mark.exhaustive(but=8)
@pytest.mark.parametrize("rule", ROUNDINGS)
@pytest.mark.parametrize(("a1", "a2"), [(-110, 61), (-64, 60), (30, 58), (-115, 55), (0, 61)])
def test_limit_cycles_of_a_second_order_section(a1: int, a2: int, rule: str) -> None:
    section = Section(64, a1, a2, 6, 7, rule)
    found = rounding(replace(section, bits=14).graph())
    assert found.status == "proved"
    h = section.response(1500)
    low, high = errors(rule, 64 // math.gcd(64, a1, a2))
    assert found.error is not None
    sums = [sum(by(k * low, k * high) for k in h) for by in (min, max)]
    assert found.error == pytest.approx([*map(float, sums)], rel=1e-9)
    assert section.largest_limit_cycle() <= found.limit


def test_there_are_limit_cycles_to_bound() -> None:
    assert Section(64, -110, 61, 6, 7).largest_limit_cycle() >= 5
    assert Section(64, -64, 60, 6, 7, "half_up").largest_limit_cycle() >= 3


def test_an_oscillation_of_a_register_that_wraps_is_not_one_of_rounding() -> None:
    """With |a1| + |a2| >= 1 it goes on for ever at zero input, near full scale; one that saturates comes to rest."""
    section = Section(64, -115, 60, 6, 10)
    found = overflow(section.graph(), input_output=[-511, 511])
    assert found.status == "refuted"
    assert found.run is not None
    (values,) = found.run.inputs.values()
    assert section.overflows_at(values) == found.run.ticks - 1
    rng, rest = random.Random(1), [0.0] * 400
    driven = max(([*values, *rng.choices((-511.0, 511.0), k=k), *rest] for k in range(10, 30)), key=section.size_at_end)
    bound = rounding(replace(section, bits=14).graph()).limit
    late = {}
    for kind in ("wrap", "saturate"):
        blocks = dict(found.run.graph.blocks)
        blocks["filter"] = replace(section, overflow=kind).graph().blocks["filter"]
        blocks["worst_input"] = RepeatingSequence(values=tuple(driven))
        result = simulate(found.run.graph.changed(blocks=blocks), samples=len(driven))
        late[kind] = abs(result["filter.output"].values[-50:]).max()
    assert late["saturate"] <= bound < 30.0 < 250.0 < late["wrap"]


def sections(seed: int, many: int) -> list[Section]:
    rng, made = random.Random(seed), list[Section]()
    while len(made) < many:
        a2, a1 = rng.randint(-56, 60), rng.randint(-110, 110)
        if abs(a1) < 64 + a2:  # the triangle of stable sections
            made.append(Section(rng.randint(-40, 40) or 1, a1, a2, 6, rng.choice([6, 7]), rng.choice(ROUNDINGS)))
    return made


@pytest.mark.parametrize("seed", [1, *[pytest.param(s, marks=pytest.mark.exhaustive) for s in range(2, 30)]])
def test_proved_and_refuted_overflows_beside_all_states_that_can_be_reached(seed: int) -> None:
    """No input of its range overflows what is proved; what is refuted overflows by the input that is shown."""
    rng, outcomes = random.Random(seed), set()
    for section in sections(seed, 3):
        sums = float(sum(map(abs, section.response(400)))) * abs(section.b) / 64
        most = max(1, min(2_000, round(section.most / sums * rng.uniform(0.5, 1.6))))
        found = overflow(section.graph(), input_output=[-most, most])
        truth = section.overflows(range(-most, most + 1, max(1, most // 2)))
        outcomes.add(found.status)
        assert found.status != "proved" or not truth
        if found.run is not None:
            ((signal, values),) = found.run.inputs.items()
            assert (signal, section.overflows_at(values)) == ("input.output", found.run.ticks - 1)
            assert max(map(abs, values)) <= most
            again = simulate(found.run.graph)
            assert again.overflows["filter"] == 1
            assert again.ticks == found.run.ticks
    assert outcomes - {"open"}


@pytest.mark.parametrize("seed", [1, *[pytest.param(s, marks=pytest.mark.exhaustive) for s in range(2, 20)]])
def test_outputs_keep_near_those_in_exact_arithmetic(seed: int) -> None:
    rng = random.Random(seed)
    for section in sections(seed, 4):
        section = replace(section, bits=16)
        found = rounding(section.graph(), ends=(-14, 14))
        assert found.status == "proved"
        assert found.error is not None
        for _ in range(3):
            y1 = y2 = 0
            e1 = e2 = Fraction(0)
            for tick in range(120):
                u = rng.choice((-14, 14)) if tick < 60 else 0
                y = section.unlimited(u, y1, y2)
                e = Fraction(section.b * u) / 64 - (section.a1 * e1 + section.a2 * e2) / 64
                assert found.error[0] - 1e-9 <= y - e <= found.error[1] + 1e-9
                y1, y2, e1, e2 = y, y1, e, e1


@pytest.mark.parametrize("offset", [0.0, 1e-3])
@pytest.mark.parametrize(("end", "status"), [(31.0, "proved"), (33.0, "refuted")])
def test_a_slow_gain_is_held_from_one_period_to_the_next(end: float, status: str, offset: float) -> None:
    """3 u[0] - u[1] is at most 4 times the largest u, wherever in the period the gain ticks; the word ends at 128."""
    word = Fixed(12, 4)
    blocks: dict[str, Block] = {
        "source": Constant(value=0.0),
        "input": FixedQuantiser(output_format=word),
        "gain": FixedGain(gain=3.0, input_format=word, output_format=word),
        "difference": FixedDifference(input_format=word, output_format=word),
    }
    wires = ["source.output -> input.input", "input.output -> gain.input"]
    wires += ["gain.output -> difference.first", "input.output -> difference.second"]
    clocks: dict[str, Any] = {"rates": {"gain": "500 Hz"}, "offsets": {"gain": offset} if offset else {}}
    graph = Graph(name="two rates", rate="1 kHz", blocks=blocks, wires=wires, **clocks)
    found = prove(graph, no_overflow=True, input_ranges={"source.output": [-end, end]}).digital[0]
    assert found.status == status
    assert max(room.high for room in found.rooms) == pytest.approx(4.0 * end * 16.0)
