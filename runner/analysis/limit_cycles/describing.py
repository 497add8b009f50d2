"""Describing functions: the gain of a nonlinear block for a sine of some amplitude, from the
fundamental of its output.

    N(A) = 1 / (pi A) integral over a turn of y(A sin t) (sin t + j cos t) dt

in closed form for a relay, with hysteresis, a sign, a saturation, a dead zone, a play, a quantiser,
a sine and a cosine (Gelb and Vander Velde, Multiple-Input Describing Functions, 1968, appendix B),
and by quadrature for any other block without memory. Sines are about the middle of the
characteristic, which is odd about it.
"""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
import scipy.special

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.electronics.comparator import Comparator
from proofmass.blocks.signals.backlash import Backlash
from proofmass.blocks.signals.cosine_function import CosineFunction
from proofmass.blocks.signals.dead_zone import DeadZone
from proofmass.blocks.signals.quantiser import Quantiser
from proofmass.blocks.signals.relay import Relay
from proofmass.blocks.signals.saturation import Saturation
from proofmass.blocks.signals.sign import Sign
from proofmass.blocks.signals.sine_function import SineFunction
from proofmass.runner.plan.constants import constants_of

Describing = Callable[[float], complex]
_POINTS = 1 << 10  # of a turn, for blocks without a closed form


def relay(amplitude: float, size: float, hysteresis: float = 0.0) -> complex:
    """Return N(A) of a relay of +-size that switches at +-hysteresis; 0 if the amplitude does not reach it.

    >>> abs(relay(1.0, math.pi / 4.0))
    1.0
    """
    if amplitude <= hysteresis or amplitude <= 0.0:
        return 0.0
    late = hysteresis / amplitude
    return 4.0 * size / (math.pi * amplitude) * complex(math.sqrt(1.0 - late * late), -late)


def saturation(amplitude: float, limit: float, slope: float = 1.0) -> float:
    """Return N(A) of a gain that is limited to inputs of +-limit.

    >>> saturation(0.5, 1.0), round(saturation(2.0, 1.0), 6)
    (1.0, 0.608998)
    """
    if amplitude <= limit:
        return slope
    part = limit / amplitude
    return slope * 2.0 / math.pi * (math.asin(part) + part * math.sqrt(1.0 - part * part))


def dead_zone(amplitude: float, width: float, slope: float = 1.0) -> float:
    """Return N(A) of a gain that passes nothing between +-width: the complement of a saturation.

    >>> dead_zone(0.5, 1.0), round(dead_zone(2.0, 1.0), 6)
    (0.0, 0.391002)
    """
    return slope - saturation(amplitude, width, slope)


def quantiser(amplitude: float, step: float, levels: float = math.inf) -> float:
    """Return N(A) of a quantiser with a level at zero: relays at odd halves of a step, `levels` at
    most on each side.

    >>> quantiser(0.4, 1.0), round(quantiser(100.0, 1.0), 3)
    (0.0, 1.0)
    """
    switched = min(math.floor(amplitude / step + 0.5), levels)
    parts = (((2 * k - 1) * step / (2.0 * amplitude)) ** 2 for k in range(1, int(switched) + 1))
    return 4.0 * step / (math.pi * amplitude) * sum(math.sqrt(max(1.0 - part, 0.0)) for part in parts)


def mid_rise_quantiser(amplitude: float, step: float, levels: float = math.inf) -> float:
    """Return N(A) of a quantiser without a level at zero: relays at whole steps, `levels` at most on each side.

    >>> mid_rise_quantiser(0.4, 1.0) == abs(relay(0.4, 0.5)), round(mid_rise_quantiser(100.0, 1.0), 3)
    (True, 1.0)
    """
    switched = min(math.floor(amplitude / step), levels - 1)
    parts = ((k * step / amplitude) ** 2 for k in range(1, int(switched) + 1))
    return 4.0 * step / (math.pi * amplitude) * (0.5 + sum(math.sqrt(max(1.0 - part, 0.0)) for part in parts))


def backlash(amplitude: float, width: float) -> complex:
    """Return N(A) of a play of some width: 0 if the amplitude does not cross half of it.

    >>> backlash(0.5, 1.0), abs(backlash(1e9, 1.0) - 1.0) < 1e-8
    (0.0, True)
    """
    if amplitude <= 0.5 * width:
        return 0.0
    part = 1.0 - width / amplitude
    left = 1.0 - part * part
    return complex(0.5 + (math.asin(part) + part * math.sqrt(left)) / math.pi, -left / math.pi)


def sine(amplitude: float) -> float:
    """Return N(A) of the sine of a signal, 2 J1(A) / A.

    >>> round(sine(1e-9), 9), round(sine(1.0), 6)
    (1.0, 0.880101)
    """
    return 2.0 * float(scipy.special.j1(amplitude)) / amplitude


def _closed(block: Block, output: str) -> Describing | None:
    """Return N(A) of a block that has it in closed form."""
    match block:
        case Relay():
            size, width = 0.5 * (block.on - block.off), 0.5 * (block.upper - block.lower)
            return lambda amplitude: relay(amplitude, size, width)
        case Comparator():
            return lambda amplitude: relay(amplitude, 1.0, 0.5 * block.hysteresis)
        case Sign():
            return lambda amplitude: relay(amplitude, 1.0)
        case Saturation() if block.lowest == -block.highest:
            return lambda amplitude: saturation(amplitude, block.highest)
        case DeadZone() if block.lowest == -block.highest:
            return lambda amplitude: dead_zone(amplitude, block.highest)
        case Quantiser() if block.lowest == -block.highest and output == "output":
            step, sides = 2.0 * block.highest / (block.levels - 1), block.levels // 2
            stairs = quantiser if block.levels % 2 else mid_rise_quantiser
            return lambda amplitude: stairs(amplitude, step, sides)
        case Backlash():
            return lambda amplitude: backlash(amplitude, block.width)
        case SineFunction():
            return lambda amplitude: block.amplitude * sine(amplitude)
        case CosineFunction():
            return lambda amplitude: 0.0
        case _:
            return None


def describing_function(block: Block, input: str, output: str, period: float) -> Describing:
    """Return N(A) of a block from an input to an output; raises `ValueError` if it has none."""
    closed = _closed(block, output)
    if closed is not None:
        return closed
    behaviour = type(block).output_functions[output]
    if type(block).continuous() or type(block).state_class() is not None or {*behaviour.meanings} - {Meaning.INPUT}:
        raise ValueError("has a memory, so its describing function is not known")
    constants = constants_of(block, block, period)
    given = [type(block).inputs[name].default or 0.0 for name in behaviour.arguments]
    place, function = behaviour.arguments.index(input), behaviour.function
    before, after = given[:place], given[place + 1 :]
    t = (np.arange(_POINTS) + 0.5) * (2.0 * math.pi / _POINTS)

    @cache
    def by_quadrature(amplitude: float) -> complex:
        swing = (amplitude * np.sin(t)).tolist()
        y = np.array([float(function(constants, *before, x, *after)) for x in swing])
        y -= y.mean()
        return complex(np.mean(y * np.sin(t)), np.mean(y * np.cos(t))) * 2.0 / amplitude

    return by_quadrature
