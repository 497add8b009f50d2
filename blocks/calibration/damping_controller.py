"""Damping controller: c += gain * sum of (h_R[k] - h[k]) over the lags first to last, once per period.

h is the impulse response of the device, h_R that of its reference model (Sarraf et al. 2012,
section 2.1, steps v and vi). Which coefficients the paper sums is not said; over all lags the sum
is the static response, which holds no damping: a few lags it must be, and the default is h[1]
alone.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class DampingController(Block):
    """Integrates the error of an impulse response into the damping of a reference model, at the rate of periods."""

    initial: float = param("kg/s", "A priori damping.", default=3.4e-3, above=0.0)
    gain: float = param("kg/s/V", "Damping per volt of summed error.", default=1.453e-3)
    lowest: float = param("kg/s", "Damping that the correction never goes below.", default=3.4e-6, above=0.0)
    cells: int = param("1", "Entries of the impulse responses.", default=16, at_least=1, at_most=4096)
    first: int = param("1", "First lag of the sum.", default=1, at_least=0)
    last: int = param("1", "Last lag of the sum.", default=1, at_least=0)

    measured = Input("V", "Impulse response h of the device.", shape=("cells",))
    modelled = Input("V", "Impulse response h_R of the reference model.", shape=("cells",))


class State(NamedTuple):
    damping: float


@DampingController.requires
def requires(p: DampingController) -> Iterator[tuple[str, str]]:
    if p.last >= p.cells:
        yield "last", f"less than cells = {p.cells}"
    if p.first > p.last:
        yield "first", f"at most last = {p.last}"


@DampingController.start
def start(p: DampingController) -> State:
    return State(p.initial)


def corrected(p: DampingController, x: State, measured: list[float], modelled: list[float]) -> float:
    error = 0.0
    for k in range(p.first, p.last + 1):
        error += modelled[k] - measured[k]
    moved = x.damping + p.gain * error
    return moved if moved > p.lowest else p.lowest


@DampingController.output("kg/s")
def damping(p: DampingController, x: State, measured: list[float], modelled: list[float]) -> float:
    """Damping for the reference model, corrected in the same tick."""
    return corrected(p, x, measured, modelled)


@DampingController.update
def update(p: DampingController, x: State, measured: list[float], modelled: list[float]) -> State:
    return State(corrected(p, x, measured, modelled))
