"""Static tests before and after: errors = N'(1) - N(0) and N(1) - N(0) (digital quartz accelerometer, Fig. 13).

N(0) is the output of the initial state, N'(1) that after the gains have drifted, N(1) that after
compensation. The residual error of eq. 31, printed upside down, is (N(1) - N(0)) / (N'(1) - N(0)).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input


class StaticComparison(Block):
    """Compares the averaged outputs of a first, a second and all further static tests."""

    response = Input("1", "Averaged output.")
    read = Input("1", "Whether it is the result of a test.", dtype=bool)


class State(NamedTuple):
    tests: int
    reference: float
    uncompensated: float
    compensated: float


@StaticComparison.output("1")
def reference(p: StaticComparison, x: State) -> float:
    """Output of the first test, N(0); zero before."""
    return x.reference


@StaticComparison.output("1")
def uncompensated_error(p: StaticComparison, x: State) -> float:
    """Output of the second test less that of the first; zero before."""
    return x.uncompensated - x.reference if x.tests > 1 else 0.0


@StaticComparison.output("1")
def compensated_error(p: StaticComparison, x: State) -> float:
    """Output of the last test less that of the first, from the third test on; zero before."""
    return x.compensated - x.reference if x.tests > 2 else 0.0


@StaticComparison.update
def update(p: StaticComparison, x: State, response: float, read: bool) -> State:
    if not read:
        return x
    if x.tests == 0:
        return State(1, response, 0.0, 0.0)
    if x.tests == 1:
        return State(2, x.reference, response, 0.0)
    return State(3, x.reference, x.uncompensated, response)
