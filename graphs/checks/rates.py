"""Rates and clock offsets of a flat graph."""

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import groupby

from proofmass.blocks.declaration.problem import Problem, problems_of_table
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.rates import LARGEST_RATIO, common_base_rate, with_offsets, write_rate, write_seconds
from proofmass.graphs.model.targets import CLOCK_OFFSET

_MANY_TIMES = 3  # base ticks in one of the fastest block, from which on a note says so
_SHORT = 8  # characters of a rate


def rate_problems(graph: FlatGraph) -> Iterator[Problem]:
    """Yield what is wrong with rates and clock offsets: missing, of blocks without a clock, or too far apart."""
    discrete = [name for name, block in graph.blocks.items() if not type(block).continuous()]
    owners = _owners(graph)
    for name in graph.rates:
        if name not in discrete:
            yield Problem(
                message="a continuous block has no rate: it is integrated from each tick of the graph to the next",
                hint="leave the rate out, or give it to the blocks that sample this one",
                path=("blocks", name, "rate"),
            )
    without = [name for name in discrete if name not in graph.rates]
    if graph.rate is None and len(without) == len(discrete):
        hint = 'add rate = "50 kHz" at the top of the file'
        yield Problem(message="the graph has no rate", key="rate", hint=hint, note=bool(graph.exports))
    elif graph.rate is None:
        yield from _without_rate(graph, without)
    yield from _offsets(graph)
    if owners and common_base_rate(owners) is None:
        yield _far_rates(graph, owners)


def _owners(graph: FlatGraph) -> dict[Fraction, str]:
    """Return the rates of a graph, each with the first block that has it."""
    owners: dict[Fraction, str] = {}
    for name, block in graph.blocks.items():
        rate = None if type(block).continuous() else graph.rates.get(name, graph.rate)
        if rate is not None:
            owners.setdefault(rate, name)
    return owners


def _far_rates(graph: FlatGraph, owners: Mapping[Fraction, str]) -> Problem:
    """Rates without a common multiple within reach, each with a block that has it."""
    known = sorted(owners)
    shown = [f"{owners[rate]} at {write_rate(rate)}" for rate in known]
    odd = max((rate for rate in known if rate != graph.rate), key=lambda rate: (rate.denominator, rate.numerator))
    main = next((rate for rate in known if rate == graph.rate), next(rate for rate in known if rate != odd))
    near = main * round(odd / main) if odd > main else main / round(main / odd)
    return Problem(
        message="the rates have no common base rate within reach",
        key="rate",
        got=", ".join(shown if len(shown) <= 4 else [*shown[:2], "…", *shown[-2:]]),
        expected=f"at most {LARGEST_RATIO:,} ticks of their least common multiple in one tick of the slowest",
        hint=f"make the rates ratios of small numbers: {write_rate(near)} for {owners[odd]}, for example",
        path=("blocks", owners[odd], "rate") if owners[odd] in graph.rates else ("rate",),
    )


def base_rate_notes(graph: FlatGraph) -> Iterator[Problem]:
    """Yield a note where rates meet only in a base rate far above them, which is a run's."""
    owners = _owners(graph)
    base, fastest = common_base_rate(owners), max(owners, default=Fraction(1))
    if base is None or base < _MANY_TIMES * fastest:
        return
    odd = max((rate for rate in owners if rate != fastest), key=lambda rate: (fastest / rate).denominator)
    yield Problem(
        message=f"the rates meet only at {write_rate(base)}, the base rate of a run",
        got=f"{write_rate(odd)}, and {owners[fastest]} at {write_rate(fastest)}",
        hint=f"that is {base / fastest} times the ticks; {_keeps(fastest, odd)} would keep {write_rate(fastest)}",
        note=True,
        path=("blocks", owners[odd], "rate") if owners[odd] in graph.rates else ("rate",),
    )


def _keeps(fastest: Fraction, odd: Fraction) -> str:
    """Return a rate near `odd` that divides the fastest, one short to write, if any."""
    ratio = fastest / odd
    divisors = range(max(1, int(ratio / 2)), int(2 * ratio) + 2)
    near = [(write_rate(fastest / divisor), abs(math.log(ratio / divisor))) for divisor in divisors]
    return min(near, key=lambda rate: (len(rate[0]) > _SHORT, rate[1]))[0]


def _offsets(graph: FlatGraph) -> Iterator[Problem]:
    """Clock offsets of blocks without a clock, of a period or more, and those that ask for too many base ticks."""
    for name, offset in graph.offsets.items():
        bad, rate = problems_of_table("blocks", name, CLOCK_OFFSET), graph.rates.get(name, graph.rate)
        got = write_seconds(offset)
        if type(graph.blocks[name]).continuous():
            yield bad("a continuous block has no clock", hint="give the offset to the blocks that sample this one")
        elif rate is not None and offset * rate >= 1:
            expected, hint = f"less than {write_seconds(1 / rate)}, its period", "a delay of whole ticks is a Delay"
            yield bad("the clock offset is too long", got=got, expected=expected, hint=hint)
        elif rate is not None and with_offsets(rate, [offset]) > LARGEST_RATIO * rate:
            expected = f"a fraction of the period with at most {LARGEST_RATIO:,} below the line"
            hint = "choose an offset that is a simple part of the period"
            yield bad("the clock offset meets no tick", got=got, expected=expected, hint=hint)


def _without_rate(graph: FlatGraph, names: Sequence[str]) -> Iterator[Problem]:
    """Yield blocks without a rate; once for all of a subgraph, at its table: its file may serve other graphs."""
    for block, of_own in groupby(sorted(names), lambda name: name.partition(".")[0]):
        inside = [name.partition(".")[2] for name in of_own]
        shortened = ", ".join([*inside[:4], *([f"and {len(inside) - 4} more"] if len(inside) > 4 else [])])
        yield Problem(
            message=f"{'has' if inside == [''] else 'blocks of it have'} no rate, and neither has the graph",
            got=shortened,
            hint=f'add rate = "50 kHz" at the top of the file, or to this {"block" if inside == [""] else "subgraph"}',
            note=bool(graph.exports),
            path=("blocks", block),
        )
