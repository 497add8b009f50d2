"""Least-squares controller: (ln k, ln c) += (J'J)^-1 J' (y - y_R), once per record, J = (dy_R/d ln k, dy_R/d ln c).

Where a GaussNewtonController fits correlated responses, this one fits every sample of a record that
is many periods long. Response, model and both derivatives come through equal high-pass filters: an
acceleration below their corner is taken off, and what it has in common with the chips falls with
the length of the record. Beyond Sarraf et al. 2012, whose section 4 leaves calibration in operation
to the future.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.calibration.gauss_newton_controller import stepped
from proofmass.blocks.declaration.declare import Block, Input, param


class LeastSquaresController(Block):
    """Fits stiffness and damping of a reference model to long records of a device."""

    initial_stiffness: float = param("N/m", "A priori stiffness.", default=49.5627, above=0.0)
    initial_damping: float = param("kg/s", "A priori damping.", default=3.4e-3, above=0.0)
    largest_step: float = param("1", "Relative change after one record at most.", default=0.2, above=0.0, below=1.0)
    samples: int = param("1", "Samples of a record.", default=8184, at_least=2)
    settling: int = param("1", "First samples of each record that the filters settle in.", default=1023, at_least=0)

    measured = Input("V", "Response y of the device.")
    modelled = Input("V", "Response y_R of the reference model.")
    by_stiffness = Input("V", "Derivative of y_R by the logarithm of the stiffness.")
    by_damping = Input("V", "Derivative of y_R by the logarithm of the damping.")


class State(NamedTuple):
    stiffness: float
    damping: float
    sample: int
    kk: float
    kc: float
    cc: float
    kr: float
    cr: float


@LeastSquaresController.requires
def requires(p: LeastSquaresController) -> Iterator[tuple[str, str]]:
    if p.settling > p.samples - 2:
        yield "settling", f"at most samples - 2 = {p.samples - 2}: two parameters need two samples"


@LeastSquaresController.start
def start(p: LeastSquaresController) -> State:
    return State(p.initial_stiffness, p.initial_damping, 0, 0.0, 0.0, 0.0, 0.0, 0.0)


@LeastSquaresController.output("N/m")
def stiffness(p: LeastSquaresController, x: State) -> float:
    """Stiffness for the reference model, fitted to the last record."""
    return x.stiffness


@LeastSquaresController.output("kg/s")
def damping(p: LeastSquaresController, x: State) -> float:
    """Damping for the reference model, fitted to the last record."""
    return x.damping


@LeastSquaresController.update
def update(
    p: LeastSquaresController, x: State, measured: float, modelled: float, by_stiffness: float, by_damping: float
) -> State:
    weight = 1.0 if x.sample >= p.settling else 0.0
    rest = weight * (measured - modelled)
    kk = x.kk + weight * by_stiffness * by_stiffness
    kc = x.kc + weight * by_stiffness * by_damping
    cc = x.cc + weight * by_damping * by_damping
    kr, cr = x.kr + by_stiffness * rest, x.cr + by_damping * rest
    if x.sample < p.samples - 1:
        return State(x.stiffness, x.damping, x.sample + 1, kk, kc, cc, kr, cr)
    after = stepped(p.largest_step, x.stiffness, x.damping, kk, kc, cc, kr, cr)
    return State(after.stiffness, after.damping, 0, 0.0, 0.0, 0.0, 0.0, 0.0)
