"""Phase-frequency detector: output = level (up - down); an edge of the reference sets up, one of the signal down.

Where both are set both are cleared at once. Its mean is level d / (2 pi) for a phase difference d
within a turn to either side, and has the sign of the frequency difference beyond (Gardner,
Phaselock Techniques, 2005, chapter 10).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class PhaseFrequencyDetector(Block):
    """Three-state detector of a loop that locks from any frequency; its edges are rising ones."""

    level: float = param("{unit}", "Output while up alone is set.", default=1.0)
    unit: str = param("", "Unit of the output.", default="V")

    reference = Input("1", "Signal to lock to.", dtype=bool)
    signal = Input("1", "Signal to lock: the oscillator.", dtype=bool)


class State(NamedTuple):
    ahead: int  # 1 while up is set, -1 while down is
    reference: bool
    signal: bool


def following(x: State, reference: bool, signal: bool) -> int:
    """Up less down, once the edges of this tick are in."""
    up = x.ahead > 0 or (reference and not x.reference)
    down = x.ahead < 0 or (signal and not x.signal)
    return (1 if up else 0) - (1 if down else 0)


@PhaseFrequencyDetector.output("{unit}")
def output(p: PhaseFrequencyDetector, x: State, reference: bool, signal: bool) -> float:
    """The level while the reference is ahead, its negative while the signal is, else zero."""
    return p.level * float(following(x, reference, signal))


@PhaseFrequencyDetector.update
def update(p: PhaseFrequencyDetector, x: State, reference: bool, signal: bool) -> State:
    return State(following(x, reference, signal), reference, signal)
