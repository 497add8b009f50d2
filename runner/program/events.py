"""Events of a tick in a program with slopes: where something enters beside what lasts, or is listened to.

A wire that a run chooses, a deviate that is drawn, and a number that is rounded are events. They
are counted from 0 on in each tick. All lanes tell what they are alike; each has the slope there,
and may be the direction of one of them.
"""

from collections.abc import Callable
from typing import NamedTuple

from proofmass.blocks.arithmetic import rounding
from proofmass.runner.program.build import Builder, operand
from proofmass.runner.program.form import FLOAT, INTEGER, Function, Kind, Operand, Storage
from proofmass.runner.program.tangent_rules import (
    REST,
    TangentRule,
    TangentStep,
    masked,
    origin_of,
    within_levels,
)

MOST = 4096  # events of a tick that have a place; any more are counted alone
COUNT, OWNER, MATRICES, VALUES = range(4)  # of the state: events so far, the block that runs, what becomes of matrices,
OF_STATE = 4  # and whether deviates have values, or are 0
EVENT, MOVED, UNKNOWN = range(3)  # of a lane: the event whose direction it is, whether numbers of matrices have slopes,
OF_LANE = 3  # and NaN once a number that has a slope was taken apart by its bits, else 0
KIND, SOURCE, VALUED, ENTERING, DROP = range(5)  # told: kind, block or wire, value, slope by its direction, a code
TOLD = 5
WIRE, DRAWN, ROUNDED, DROPPED, LEVELLED = range(5)  # kinds of events
PASSED, HEARD, ENTERED, CUT = range(4)  # modes of wires: what enters is added, or takes the place of the slope
GAIN, DEVIATION = range(2)  # of a block's quantiser of one bit; the gain is NaN without a model
OF_ONE_BIT = 2

_AT_WIRE, _AT_DEVIATE, _AT_DROP = "wire with an event", "deviate with an event", "shift with an event"


class Events(NamedTuple):
    """Arrays of events among the parameters of a program, in their order."""

    modes: Storage  # of wires
    one_bit: Storage  # gains and deviations of quantisers of one bit, by block
    state: Storage
    told: Storage
    heard: Storage  # slope at each event: another in each lane
    lane: Storage  # another in each lane

    @classmethod
    def of(cls, builder: Builder) -> "Events":
        """Return them as parameters of a function that is being written."""
        return cls(
            builder.array(INTEGER, None, "modes"),
            builder.array(FLOAT, None, "one_bit"),
            builder.array(INTEGER, OF_STATE, "state", True),
            builder.array(FLOAT, None, "told", True),
            builder.array(FLOAT, None, "heard", True),
            builder.array(FLOAT, OF_LANE, "lane", True),
        )


class Marks(NamedTuple):
    """Functions that give a number back, and that have rules of their own where slopes are followed."""

    wires: dict[Kind, Function]  # of the value and the number of a wire
    deviate: Function
    drop: Function  # of the result, what was rounded, the places, and the code of what drops
    rest: Function  # of 0, the part that a search leaves over, the whole and the scale: no event

    @classmethod
    def beside(cls, builder: Builder) -> "Marks":
        """Return them for the program of a builder."""
        return cls(
            {kind: _marked(builder, _AT_WIRE, kind, INTEGER) for kind in (FLOAT, INTEGER)},
            _marked(builder, _AT_DEVIATE, FLOAT),
            _marked(builder, _AT_DROP, INTEGER, INTEGER, INTEGER, FLOAT),
            _marked(builder, REST, *(INTEGER,) * 4),
        )


def _marked(builder: Builder, origin: str, *kinds: Kind) -> Function:
    inner = builder.beside(f"{origin.replace(' ', '_')}_{kinds[0].name.lower()}")
    inner.origin = origin
    first, *_ = [inner.parameter(kind, f"given_{number}") for number, kind in enumerate(kinds)]
    inner.give(first)
    return inner.function()


def _entering(
    s: TangentStep, kind: int, value: Operand, slope: Operand, factor: Operand | float, drop: Operand | float = 0.0
) -> Operand:
    """Write an event of the block that runs; returns the slope of what enters there."""
    owner = s.builder.load(Events(*s.beside).state, OWNER)
    return _told(s, kind, owner, value, slope, operand(factor), drop)


def _told(
    s: TangentStep,
    kind: int,
    source: Operand,
    value: Operand,
    slope: Operand,
    factor: Operand,
    drop: Operand | float = 0.0,
) -> Operand:
    events, builder = Events(*s.beside), s.builder
    compute, store = builder.compute, builder.store
    count = builder.load(events.state, COUNT)
    place = compute("select", compute("less_integers", count, MOST), count, MOST - 1)
    first = compute("multiply_integers", place, TOLD)
    told = {
        KIND: float(kind),
        SOURCE: compute("float_of_integer", source),
        VALUED: s.slopes.number(value),
        ENTERING: factor,
        DROP: operand(drop),
    }
    for entry, what in told.items():
        store(events.told, compute("add_integers", first, entry), what)
    store(events.heard, place, slope)
    store(events.state, COUNT, compute("add_integers", count, 1))
    own = compute("equal", builder.load(events.lane, EVENT), compute("float_of_integer", count))
    return compute("select", own, factor, 0.0)


def _wire(s: TangentStep) -> Operand:
    events, builder, (value, number) = Events(*s.beside), s.builder, s.x
    compute = builder.compute
    mode = builder.load(events.modes, number)
    slope = builder.variable(FLOAT, "slope", s.dx[0])
    with builder.when(compute("less_integers", PASSED, mode)):
        factor = compute("float_of_truth", compute("less_integers", HEARD, mode))
        entering = _told(s, WIRE, number, value, s.dx[0], factor)
        kept = compute("select", compute("equal_integers", mode, CUT), 0.0, s.dx[0])
        builder.set(slope, compute("add", kept, entering))
    return builder.get(slope)


def _rounded(s: TangentStep) -> Operand:
    return s.slopes.plus(s.dx[0], _entering(s, ROUNDED, s.x[0], s.dx[0], 1.0))


def _dropped(s: TangentStep) -> Operand:
    slopes, (_, shifted, places, drop) = s.slopes, s.x
    step = slopes.number(slopes.compute("shift_left", 1, places))
    value = slopes.compute("divide", slopes.number(shifted), step)
    slope = slopes.over(s.dx[1], step)
    return slopes.plus(slope, _entering(s, DROPPED, value, slope, 1.0, drop))


def _level(inside: Callable[[TangentStep], Operand], compared: int, quantises: bool) -> TangentRule:
    """Return the rule of a function that chooses a level: by the model of one bit where there is one.

    Elsewhere what is `inside` the levels is rounded, and a comparison has no slope.
    """

    def rule(s: TangentStep) -> Operand:
        slopes, builder = s.slopes, s.builder
        events, value, slope = Events(*s.beside), s.x[compared], s.dx[compared]
        place = builder.compute("multiply_integers", builder.load(events.state, OWNER), OF_ONE_BIT)
        gain = builder.load(events.one_bit, builder.compute("add_integers", place, GAIN))
        modelled = builder.compute("equal", gain, gain)
        made = builder.variable(FLOAT, "slope", 0.0)
        with builder.when(modelled):
            deviation = builder.load(events.one_bit, builder.compute("add_integers", place, DEVIATION))
            builder.set(made, slopes.plus(slopes.times(slope, gain), _entering(s, LEVELLED, value, slope, deviation)))
        if quantises:
            with builder.when(builder.compute("not", modelled)):
                clipped, slope = _clipped(s), inside(s)
                builder.set(made, slopes.plus(slope, _entering(s, ROUNDED, clipped, slope, 1.0)))
        return builder.get(made)

    return rule


def _clipped(s: TangentStep) -> Operand:
    compute, (value, last) = s.builder.compute, s.numbers()
    above = compute("select", compute("less", 0.0, value), value, 0.0)
    return compute("select", compute("less", above, last), above, last)


def _taken_apart(s: TangentStep) -> Operand:
    """Write that a number is taken apart, if it has a slope: what its bits decide has none, and none is known."""
    lane, slope = Events(*s.beside).lane, s.slopes.undefined(*s.dx)
    s.builder.store(lane, UNKNOWN, s.builder.compute("add", s.builder.load(lane, UNKNOWN), slope))
    return slope


AT_WIRES: dict[str, TangentRule] = {_AT_WIRE: _wire, "and": masked(_taken_apart)}
OF_NOISE: dict[str, TangentRule] = {
    _AT_DEVIATE: lambda s: _entering(s, DRAWN, s.x[0], s.dx[0], 1.0),
    _AT_DROP: _dropped,
    origin_of(rounding.round_half_even): _rounded,
    origin_of(rounding.round_down): _rounded,
    origin_of(rounding.nearest_level): _level(within_levels, 0, True),
    origin_of(rounding.nearest_even_level): _level(within_levels, 0, True),
    origin_of(rounding.two_level): _level(within_levels, 1, False),
}
