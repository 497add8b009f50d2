"""Problems of maps: a wire with too many values, and a block that has no slope."""

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Endpoint

MOST_VALUES = 4_096  # of a wire that is cut, in a map
_OUTSIDE = "open the loop so that this block lies outside, or linearise at another time"


def too_many(node: Endpoint, values: int) -> Problem:
    """Return the problem of a wire with so many values in a map."""
    signal = ".".join(node)
    return Problem(
        message=f"the loop has too many values of {signal} in its common period",
        key=signal,
        got=f"{values:,}",
        expected=f"at most {MOST_VALUES:,}",
        hint="open the loop at its slowest wire, where a period has few values",
        path=("blocks", node[0]),
    )


def not_linear(at: str, got: str, hint: str = _OUTSIDE) -> Problem:
    """Return the problem of a function or a state of a block, "block.what", that has no slope."""
    name, _, what = at.rpartition(".")
    return Problem(
        message=f"cannot be linearised: {what} has no derivative here",
        got=got,
        expected="arithmetic, comparisons and functions of math on values that signals change",
        hint=hint,
        path=("blocks", name),
    )
