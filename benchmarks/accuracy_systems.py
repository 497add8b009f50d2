"""Kinds of systems of the table of accuracies: nonlinear, stiff and switching ones, each with a graph and a reference.

Their equations of motion are written here and not in blocks (`accuracy_references` integrates them).
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.accuracy_references import Rates, by_pieces, by_scipy
from proofmass.blocks import (
    Constant,
    Difference,
    DuffingSpring,
    ElectrostaticSoftening,
    Exponential,
    Gain,
    GapClosingActuator,
    Integrator,
    Interferometer,
    LowPass,
    MassBetweenStops,
    MassSpringDamper,
    PhaseMixer,
    Power,
    Ramp,
    Relay,
    Saturation,
    Sine,
    SqueezeFilmDamping,
    Step,
    Sum,
    VoltageControlledOscillator,
)
from proofmass.blocks.declaration.declare import Block, param
from proofmass.graphs.model.build import Graph


class System(NamedTuple):
    """A graph, the signal to look at, and its values at given times by other means."""

    name: str
    graph: Graph
    signal: str
    expected: Callable[[Any], Any]


def graph(blocks: dict[str, Any], wires: Sequence[str], signal: str, rate: Any, seconds: Any, **more: Any) -> Graph:
    integration = {"sources": "continuous", **more}
    return Graph(
        name="accuracy",
        rate=rate,
        duration=seconds,
        blocks=blocks,
        wires=wires,
        probes=[signal],
        integration=integration,
    )


def duffing(cubic: float, force: float, frequency: float, damping: float, rate: float) -> System:
    """m x'' + c x' + k x + cubic x^3 = F sin(w t), from rest."""
    m, k, w = 50e-9, 50.0, 2.0 * math.pi * frequency
    blocks = {
        "push": Sine(amplitude=force, frequency=frequency, unit="N"),
        "sum": Sum(unit="N"),
        "mass": MassSpringDamper(mass=m, damping=damping, stiffness=k),
        "spring": DuffingSpring(cubic=cubic),
    }
    wires = ["push.output -> sum.first", "spring.force -> sum.second", "sum.output -> mass.force"]
    wires.append("mass.displacement -> spring.displacement")
    made = graph(blocks, wires, "mass.displacement", rate, 4e-3)

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], (force * math.sin(w * t) - damping * y[1] - k * y[0] - cubic * y[0] ** 3) / m]

    size = force / k
    return System("Duffing", made, "mass.displacement", by_scipy(rates, [0, 0], [size, size * math.sqrt(k / m)], 0))


def hardening(cubic: float) -> System:
    """The same pushed by a constant force: its states get faster as they move."""
    m, k, c, force = 50e-9, 0.02, 1e-7, 1e-3
    blocks = {
        "push": Constant(value=force, unit="N"),
        "sum": Sum(unit="N"),
        "mass": MassSpringDamper(mass=m, damping=c, stiffness=k),
        "spring": DuffingSpring(cubic=cubic),
    }
    wires = ["push.output -> sum.first", "spring.force -> sum.second", "sum.output -> mass.force"]
    wires.append("mass.displacement -> spring.displacement")
    size = (4.0 * force / cubic) ** (1.0 / 3.0)
    speed = math.sqrt(2.0 * force * size / m)
    made = graph(blocks, wires, "mass.displacement", 20e3, 12.0 * size / speed + 1e-4)

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], (force - c * y[1] - k * y[0] - cubic * y[0] ** 3) / m]

    return System("hardening", made, "mass.displacement", by_scipy(rates, [0, 0], [size, speed], 0))


def plates(volts: float, frequency: float, rate: float, film: bool = False) -> System:
    """A voltage pulls a plate; in a film of gas of c = 1e-3 kg/s / (1 - x/h)^3 (both walls) where one is asked for."""
    m, k, gap, capacitance = 5e-9, 1.0, 2e-6, 1e-12
    damping = 1e-5
    blocks: dict[str, Any] = {
        "drive": Sine(amplitude=volts, frequency=frequency, unit="V"),
        "plates": GapClosingActuator(bias=0.0, capacitance=capacitance, gap=gap, push_pull=False),
        "mass": MassSpringDamper(mass=m, damping=damping, stiffness=k),
    }
    wires = ["drive.output -> plates.voltage", "mass.displacement -> plates.displacement"]
    if film:
        blocks |= {"film": SqueezeFilmDamping(length=300e-6, width=200e-6, gap=gap), "sum": Sum(unit="N")}
        wires += ["mass.displacement -> film.displacement", "mass.velocity -> film.velocity"]
        wires += ["plates.force -> sum.first", "film.force -> sum.second", "sum.output -> mass.force"]
    else:
        wires.append("plates.force -> mass.force")
    made = graph(blocks, wires, "mass.displacement", rate, 3e-3)
    series = sum(math.tanh(0.5 * math.pi * n * 1.5) / n**5 for n in (1, 3, 5, 7, 9))
    gas = (1.0 - 192.0 / math.pi**5 / 1.5 * series) * 18e-6 * 300e-6 * (200e-6 / gap) ** 3 if film else 0.0

    def rates(t: float, y: Any) -> list[float]:
        v = volts * math.sin(2.0 * math.pi * frequency * t)
        near, far = 1.0 - y[0] / gap, 1.0 + y[0] / gap
        c = damping + gas * (near**-3 + far**-3)
        return [y[1], (0.5 * capacitance / gap * v * v / near**2 - c * y[1] - k * y[0]) / m]

    size = capacitance * volts**2 / (4.0 * gap * k)
    name = "squeeze film" if film else "plates"
    expected = by_scipy(rates, [0, 0], [size, size * math.sqrt(k / m)], 0, stiff=film)
    return System(name, made, "mass.displacement", expected)


def softened(volts: float, rate: float) -> System:
    """A mass between two electrodes, pushed by a step at 0.3217 ms."""
    m, k, c, gap, capacitance, force, begin = 5e-9, 1.0, 1e-5, 4e-6, 0.2e-12, 2e-7, 3.217e-4
    blocks = {
        "push": Step(amplitude=force, start_time=begin, unit="N"),
        "bias": Constant(value=volts, unit="V"),
        "pair": ElectrostaticSoftening(capacitance=capacitance, gap=gap),
        "sum": Sum(unit="N"),
        "mass": MassSpringDamper(mass=m, damping=c, stiffness=k),
    }
    wires = ["push.output -> sum.first", "pair.force -> sum.second", "sum.output -> mass.force"]
    wires += ["mass.displacement -> pair.displacement", "bias.output -> pair.voltage"]
    made = graph(blocks, wires, "mass.displacement", rate, 2e-3)

    def rates(t: float, y: Any) -> list[float]:
        u = y[0] / gap
        pull = 2.0 * capacitance * volts**2 * u / (gap * (1.0 - u * u) ** 2)
        return [y[1], (force + pull - c * y[1] - k * y[0]) / m]

    moved = by_scipy(rates, [0, 0], [force / k, force / math.sqrt(k * m)], 0)

    def expected(times: Any) -> Any:
        after = times >= begin
        return np.concatenate([np.zeros((~after).sum()), moved(np.array([0.0, *(times[after] - begin)]))[1:]])

    return System("softened", made, "mass.displacement", expected)


def stops(force: float, frequency: float, restitution: float, rate: float) -> System:
    """A mass that a sine throws from stop to stop."""
    m, k, c, end, slow, w = 50e-9, 5.0, 1e-4, 1.9e-6, 1e-3, 2.0 * math.pi * frequency
    blocks = {
        "push": Sine(amplitude=force, frequency=frequency, unit="N"),
        "mass": MassBetweenStops(mass=m, damping=c, stiffness=k, restitution=restitution, sticking_speed=slow),
    }
    made = graph(blocks, ["push.output -> mass.force"], "mass.displacement", rate, 4e-3)

    def rates(mode: int) -> Rates:
        free = 0.0 if mode else 1.0
        return lambda t, y: [free * y[1], free * (force * math.sin(w * t) - c * y[1] - k * y[0]) / m]

    def ends(mode: int) -> Any:
        if mode:
            return lambda t, y: mode * (force * math.sin(w * t) - k * y[0]) / force
        return lambda t, y: end - y[0] if y[1] > 0.0 else end + y[0] if y[1] < 0.0 else end

    def then(mode: int, y: Any) -> tuple[int, Any]:
        if mode:
            return 0, y
        stuck = restitution * abs(y[1]) <= slow
        side = math.copysign(1.0, y[0])
        return (int(side) if stuck else 0), [side * end, 0.0 if stuck else -restitution * y[1]]

    speed = force / math.sqrt(k * m)
    return System(
        "stops",
        made,
        "mass.displacement",
        lambda times: by_pieces(rates, [0, 0], [end, speed], ends, then, 0)(times)[:, 0],
    )


def locked(carrier: float, own: float, gain: float, corner: float, rate: float) -> System:
    """A phase-locked loop with its carrier and the ripple of twice that."""
    blocks = {
        "carrier": Sine(frequency=carrier),
        "mixer": PhaseMixer(),
        "filter": LowPass(corner_frequency=corner, input_unit="rad", output_unit="rad"),
        "oscillator": VoltageControlledOscillator(frequency=own, gain=gain, control_unit="rad", unit="1"),
    }
    wires = ["carrier.output -> mixer.first", "oscillator.cosine -> mixer.second"]
    wires += ["mixer.phase -> filter.input", "filter.output -> oscillator.control"]
    made = graph(blocks, wires, "filter.output", rate, 30.0 / own * 10.0)
    turn = 2.0 * math.pi

    def rates(t: float, y: Any) -> list[float]:
        phase = 2.0 * math.sin(turn * carrier * t) * math.cos(turn * (own * t + y[1]))
        return [turn * corner * (phase - y[0]), gain * y[0]]

    return System("carrier loop", made, "filter.output", by_scipy(rates, [0, 0], [1.0, 1.0], 0))


def relay(half: float, corner: float, rate: float) -> System:
    """A relay with hysteresis round a lag of first order."""
    blocks = {"relay": Relay(lower=-half, upper=half, off=1.0, on=-1.0), "lag": LowPass(corner_frequency=corner)}
    wires = ["relay.output -> lag.input", "lag.output -> relay.input"]
    made = graph(blocks, wires, "lag.output", rate, 0.05)
    omega = 2.0 * math.pi * corner

    def expected(times: Any) -> Any:
        start, begin, towards, values = 0.0, 0.0, 1.0, np.zeros(len(times))
        while begin <= times[-1]:
            last = begin + math.log((towards - start) / (towards - towards * half)) / omega
            inside = (times >= begin) & (times <= last)
            values[inside] = towards + (start - towards) * np.exp(-omega * (times[inside] - begin))
            start, begin, towards = towards * half, last, -towards
        return values

    return System("relay", made, "lag.output", expected)


def thermostat(emission: float, width: float, rate: float) -> System:
    """A heater that a relay switches, T' = h - e T^4, T in units of its reference."""
    blocks = {
        "relay": Relay(lower=1.0 - width, upper=1.0 + width, off=2.0, on=0.0),
        "loss": Power(exponent=4.0, scale=emission),
        "rest": Difference(),
        "body": Integrator(initial=0.5, output_unit="1", input_unit="1"),
    }
    wires = ["body.output -> relay.input", "body.output -> loss.input", "relay.output -> rest.first"]
    wires += ["loss.output -> rest.second", "rest.output -> body.input"]
    blocks["body"] = Integrator(initial=0.5, gain=1.0, input_unit="1", output_unit="1")
    made = graph(blocks, wires, "body.output", rate, 6.0)

    def rates(mode: int) -> Rates:
        return lambda t, y: [(2.0 if mode == 0 else 0.0) - emission * y[0] ** 4]

    def ends(mode: int) -> Any:
        return lambda t, y: 1.0 + width - y[0] if mode == 0 else y[0] - (1.0 - width)

    pieces = by_pieces(rates, [0.5], [1.0], ends, lambda mode, y: (1 - mode, y), 0)
    return System("thermostat", made, "body.output", lambda times: pieces(times)[:, 0])


def fringes(gain: float, slope: float, rate: float) -> System:
    """A phase that follows the power of an interferometer, driven over the fringes by a ramp."""
    peak, corner = 20e-6, 300.0
    blocks = {
        "ramp": Ramp(slope=slope, start_time=1.2345e-3, unit="rad"),
        "light": Interferometer(peak=peak),
        "feedback": LowPass(corner_frequency=corner, gain=gain / peak, input_unit="W", output_unit="rad"),
        "sum": Difference(unit="rad"),
    }
    wires = ["ramp.output -> sum.first", "feedback.output -> sum.second", "sum.output -> light.phase"]
    wires.append("light.power -> feedback.input")
    made = graph(blocks, wires, "feedback.output", rate, 10e-3)
    omega = 2.0 * math.pi * corner

    def rates(t: float, y: Any) -> list[float]:
        return [omega * (gain * 0.5 * (1.0 + math.cos(slope * t - y[0])) - y[0])]

    def still(t: float, y: Any) -> list[float]:
        return [omega * (gain * 0.5 * (1.0 + math.cos(y[0])) - y[0])]

    def expected(times: Any) -> Any:
        begin = 1.2345e-3
        early, late = times[times < begin], times[times >= begin]
        before = by_scipy(still, [0.0], [1.0], 0)(np.array([*early, begin]))
        after = by_scipy(rates, [before[-1]], [1.0], 0)(np.array([0.0, *(late - begin)]))
        return np.concatenate([before[:-1], after[1:]])

    return System("fringes", made, "feedback.output", expected)


def clipped(gain: float, level: float, rate: float) -> System:
    """An amplifier that clips in a loop of three lags, which sustains itself."""
    omega = 2.0 * math.pi * 1e3
    blocks: dict[str, Any] = {
        "kick": Step(amplitude=0.1, duration=0.3217e-3),
        "sum": Sum(),
        "amplifier": Gain(gain=-gain),
        "clip": Saturation(lowest=-level, highest=level),
        **{name: LowPass(corner_frequency=1e3) for name in ("a", "b", "c")},
    }
    wires = ["kick.output -> sum.first", "c.output -> sum.second", "sum.output -> amplifier.input"]
    wires += ["amplifier.output -> clip.input", "clip.output -> a.input", "a.output -> b.input", "b.output -> c.input"]
    made = graph(blocks, wires, "c.output", rate, 4e-3)

    def value(mode: int, y: Any, kick: float) -> float:
        return mode * level if mode else -gain * (kick + y[0])

    def piece(kick: float, start: Any, mode: int) -> Any:
        def rates(mode: int) -> Rates:
            return lambda t, y: [omega * (y[1] - y[0]), omega * (y[2] - y[1]), omega * (value(mode, y, kick) - y[2])]

        def ends(mode: int) -> Any:
            if mode == 0:
                return lambda t, y: level - abs(gain * (kick + y[0]))
            return lambda t, y: mode * -gain * (kick + y[0]) - level

        def then(mode: int, y: Any) -> tuple[int, Any]:
            return (0 if mode else int(math.copysign(1.0, -gain * (kick + y[0])))), y

        return by_pieces(rates, start, [1.0, 1.0, 1.0], ends, then, mode)

    def expected(times: Any) -> Any:
        end = 0.3217e-3
        early = piece(0.1, [0.0, 0.0, 0.0], -1)(np.array([*times[times < end], end]))
        free = -gain * float(early[-1, 0])
        mode = int(math.copysign(1.0, free)) if abs(free) > level else 0
        late = piece(0.0, early[-1], mode)(np.array([0.0, *(times[times >= end] - end)]))
        return np.concatenate([early[:-1, 0], late[1:, 0]])

    return System("clipped loop", made, "c.output", expected)


def diode(volts: float, frequency: float, rate: float) -> System:
    """A capacitor that a source charges through a diode: v' = I (e^((u - v) / V) - 1) / C - v / RC."""
    reference, current, leak = 0.05, 1e-3, 50.0
    blocks: dict[str, Any] = {
        "source": Sine(amplitude=volts, frequency=frequency),
        "drop": Difference(),
        "diode": Exponential(scale=current / 1e-6, reference=reference),
        "one": Constant(value=current / 1e-6),
        "net": Difference(),
        "leak": Gain(gain=leak),
        "all": Difference(),
        "capacitor": Integrator(input_unit="1", output_unit="1"),
    }
    wires = ["source.output -> drop.first", "capacitor.output -> drop.second", "drop.output -> diode.input"]
    wires += ["diode.output -> net.first", "one.output -> net.second", "net.output -> all.first"]
    wires += ["capacitor.output -> leak.input", "leak.output -> all.second", "all.output -> capacitor.input"]
    made = graph(blocks, wires, "capacitor.output", rate, 5e-3)

    def rates(t: float, y: Any) -> list[float]:
        u = volts * math.sin(2.0 * math.pi * frequency * t)
        return [current / 1e-6 * (math.exp((u - y[0]) / reference) - 1.0) - leak * y[0]]

    return System("diode", made, "capacitor.output", by_scipy(rates, [0.0], [volts], 0, stiff=True))


class Two(NamedTuple):
    x: float
    v: float


class VanDerPol(Block):
    """Van der Pol's oscillator in the time of its slow part."""

    stiffness: float = param("1", "Ratio of its time scales.", default=10.0)


@VanDerPol.output("1")
def level(p: Any, x: Two) -> float:
    """First state."""
    return x.x


@VanDerPol.start
def begin(p: Any) -> Two:
    return Two(2.0, 0.0)


@VanDerPol.derivative(linear=False)
def relax(p: Any, x: Two) -> Two:
    return Two(x.v, p.stiffness * (1.0 - x.x * x.x) * x.v - x.x)


def van_der_pol(stiffness: float, rate: float, seconds: float) -> System:
    """From its slow branch, through a jump where the time is long enough."""
    made = graph({"it": VanDerPol(stiffness=stiffness)}, [], "it.level", rate, seconds)
    rates: Rates = lambda t, y: [y[1], stiffness * (1.0 - y[0] ** 2) * y[1] - y[0]]  # noqa: E731
    return System("Van der Pol", made, "it.level", by_scipy(rates, [2.0, 0.0], [2.0, 2.0], 0, stiff=stiffness > 100))


class Three(NamedTuple):
    a: float
    b: float
    c: float


class Reaction(Block):
    """Robertson's reaction, its fastest rate scaled."""

    fast: float = param("1", "Rate of the second step.", default=3e7)


@Reaction.output("1")
def product(p: Any, x: Three) -> float:
    """What comes out."""
    return x.c


@Reaction.start
def mixed(p: Any) -> Three:
    return Three(1.0, 0.0, 0.0)


@Reaction.derivative(linear=False)
def react(p: Any, x: Three) -> Three:
    slow, quick, back = 0.04 * x.a, p.fast * x.b * x.b, 1e4 * x.b * x.c
    return Three(back - slow, slow - back - quick, quick)


def reaction(fast: float) -> System:
    """Robertson's problem for 40 s."""
    made = graph({"it": Reaction(fast=fast)}, [], "it.product", 1.0, 40.0, method="radau")

    def rates(t: float, y: Any) -> list[float]:
        slow, quick, back = 0.04 * y[0], fast * y[1] ** 2, 1e4 * y[1] * y[2]
        return [back - slow, slow - back - quick, quick]

    return System("reaction", made, "it.product", by_scipy(rates, [1, 0, 0], [1.0, 1e-4, 1.0], 2, stiff=True))


def alternating(volts: float, frequency: float) -> System:
    """A slow plate under a voltage that is far faster than a tick: cases that steps once passed over."""
    m, k, c, gap, capacitance = 5e-9, 0.002, 2e-6, 10e-6, 1e-12
    blocks = {
        "drive": Sine(amplitude=volts, frequency=frequency, unit="V"),
        "plates": GapClosingActuator(bias=0.0, capacitance=capacitance, gap=gap, push_pull=False),
        "mass": MassSpringDamper(mass=m, damping=c, stiffness=k),
    }
    wires = ["drive.output -> plates.voltage", "mass.displacement -> plates.displacement", "plates.force -> mass.force"]
    made = graph(blocks, wires, "mass.displacement", 8e3, 3e-3)

    def rates(t: float, y: Any) -> list[float]:
        v = volts * math.sin(2.0 * math.pi * frequency * t)
        return [y[1], (0.5 * capacitance / gap * v * v / (1.0 - y[0] / gap) ** 2 - c * y[1] - k * y[0]) / m]

    size = capacitance * volts**2 / (4.0 * gap * k)
    expected = by_scipy(rates, [0, 0], [size, size * math.sqrt(k / m)], 0)
    return System("fast voltage", made, "mass.displacement", expected)
