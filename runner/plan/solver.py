"""A group of continuous blocks with the method that integrates it, as a plain value."""

from dataclasses import dataclass

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.continuous import radau
from proofmass.runner.continuous.methods import EXPLICIT
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.keys import LargestOf

SHARE = {"dormand_prince": 0.003, "radau": 0.1}  # of the accuracy, for one step's error
FINEST = 1e-15  # below which rounding alone decides


@dataclass(frozen=True)
class Solver:
    """A group with the method that integrates it.

    "exact" steps by matrices, x[n+1] = transition x[n] + entry (u[n], change of the ramps over the
    tick). They change if a parameter is driven or a factor moves. For what the rates are at zero u
    holds 1 in place of the first factor, or, where they are `affine`, behind the inputs. Steps of
    the other methods are `1/substeps` of a tick long; with a tolerance above zero that is the
    length of the first step.
    """

    name: str  # in generated code
    group: Group
    method: str
    substeps: int
    tolerance: float
    precision: float  # seconds
    driven: bool
    factors: tuple[Endpoint, ...] = ()  # of "exact": inputs that multiply states and other inputs
    affine: bool = False  # "exact" without factors, and rates that are not zero where states and inputs are

    @property
    def exact(self) -> bool:
        """True if matrices step the group."""
        return self.method == "exact"

    @property
    def renewed(self) -> bool:
        """True if the matrices change from tick to tick."""
        return self.driven or bool(self.factors)

    @property
    def allowed(self) -> float:
        """Error that a step may have, relative to the largest value of each state; zero where nobody watches it."""
        return max(FINEST, SHARE[self.method] * self.tolerance) if self.tolerance else 0.0

    @property
    def order(self) -> int:
        """Order of the method: the power of its length with which the error of a step falls."""
        return EXPLICIT[self.method].order if self.method in EXPLICIT else radau.ORDER

    @property
    def largest(self) -> LargestOf:
        """Key of the buffer with the largest value of each state."""
        return LargestOf(self.name)
