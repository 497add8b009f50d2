"""Gauss-Newton controller: (ln k, ln c) += (J'J)^-1 J' (h - h_R), once per period, J = (dh_R/d ln k, dh_R/d ln c).

Stiffness and damping of a reference model move together to where its impulse response fits that of
the device best, in the lags first to last. The columns of J are impulse responses too: the
derivatives s of the displacement x by ln k and ln c obey the sensitivity equations m s'' + c s' + k
s = -k x and = -c x' of two more such models in the graph. Beyond Sarraf et al. 2012, whose two
scalar controllers use one number each.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

Cells = list[float]


class State(NamedTuple):
    stiffness: float
    damping: float


def stepped(
    largest: float, stiffness: float, damping: float, kk: float, kc: float, cc: float, kr: float, cr: float
) -> State:
    """Return both parameters after one step, from the sums of J'J and J'r; unchanged where J'J is singular."""
    determinant = kk * cc - kc * kc
    if determinant <= 1e-12 * kk * cc:  # the two cannot be told apart, or there is no response yet
        return State(stiffness, damping)
    by_stiffness, by_damping = (cc * kr - kc * cr) / determinant, (kk * cr - kc * kr) / determinant
    larger = max(abs(by_stiffness), abs(by_damping))
    scale = largest / larger if larger > largest else 1.0
    return State(stiffness * (1.0 + scale * by_stiffness), damping * (1.0 + scale * by_damping))


class GaussNewtonController(Block):
    """Fits stiffness and damping of a reference model to the impulse response of a device, at the rate of periods."""

    initial_stiffness: float = param("N/m", "A priori stiffness.", default=49.5627, above=0.0)
    initial_damping: float = param("kg/s", "A priori damping.", default=3.4e-3, above=0.0)
    largest_step: float = param("1", "Relative change in one period at most.", default=0.2, above=0.0, below=1.0)
    cells: int = param("1", "Entries of the impulse responses.", default=16, at_least=2, at_most=4096)
    first: int = param("1", "First lag of the fit.", default=1, at_least=0)
    last: int = param("1", "Last lag of the fit.", default=15, at_least=1)

    measured = Input("V", "Impulse response h of the device.", shape=("cells",))
    modelled = Input("V", "Impulse response h_R of the reference model.", shape=("cells",))
    by_stiffness = Input("V", "Derivative of h_R by the logarithm of the stiffness.", shape=("cells",))
    by_damping = Input("V", "Derivative of h_R by the logarithm of the damping.", shape=("cells",))


@GaussNewtonController.requires
def requires(p: GaussNewtonController) -> Iterator[tuple[str, str]]:
    if p.last >= p.cells:
        yield "last", f"less than cells = {p.cells}"
    if p.first >= p.last:
        yield "first", f"less than last = {p.last}: two parameters need two lags"


@GaussNewtonController.start
def start(p: GaussNewtonController) -> State:
    return State(p.initial_stiffness, p.initial_damping)


def fitted(
    p: GaussNewtonController, x: State, measured: Cells, modelled: Cells, by_stiffness: Cells, by_damping: Cells
) -> State:
    kk = kc = cc = kr = cr = 0.0
    for n in range(p.first, p.last + 1):
        rest = measured[n] - modelled[n]
        kk += by_stiffness[n] * by_stiffness[n]
        kc += by_stiffness[n] * by_damping[n]
        cc += by_damping[n] * by_damping[n]
        kr += by_stiffness[n] * rest
        cr += by_damping[n] * rest
    return stepped(p.largest_step, x.stiffness, x.damping, kk, kc, cc, kr, cr)


@GaussNewtonController.output("N/m")
def stiffness(
    p: GaussNewtonController, x: State, measured: Cells, modelled: Cells, by_stiffness: Cells, by_damping: Cells
) -> float:
    """Stiffness for the reference model, fitted in the same tick."""
    return fitted(p, x, measured, modelled, by_stiffness, by_damping).stiffness


@GaussNewtonController.output("kg/s")
def damping(
    p: GaussNewtonController, x: State, measured: Cells, modelled: Cells, by_stiffness: Cells, by_damping: Cells
) -> float:
    """Damping for the reference model, fitted in the same tick."""
    return fitted(p, x, measured, modelled, by_stiffness, by_damping).damping


@GaussNewtonController.update
def update(
    p: GaussNewtonController, x: State, measured: Cells, modelled: Cells, by_stiffness: Cells, by_damping: Cells
) -> State:
    return fitted(p, x, measured, modelled, by_stiffness, by_damping)
