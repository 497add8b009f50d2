"""Places in the memory of a generated loop, each of a type of its own, and the variables that stand for them.

Two places are the same only where type and names agree, whatever the names of a user are. A variable of the loop is
`block__port`; what the generator makes up beside it ends in an underscore, `block__port__next_`, which no variable of
a user does.
"""

import re
from dataclasses import dataclass
from typing import TypeAlias

from proofmass.graphs.model.graph import Endpoint


@dataclass(frozen=True, slots=True)
class WireOf:
    """What an output holds."""

    block: str
    port: str


@dataclass(frozen=True, slots=True)
class StateField:
    """A field of a block's state."""

    block: str
    field: str


@dataclass(frozen=True, slots=True)
class OverflowsOf:
    """Ticks in which a value of a digital block saturated or wrapped."""

    block: str


@dataclass(frozen=True, slots=True)
class ConstantOf:
    """A field of a block's constants, or an entry of one that is a tuple."""

    block: str
    field: str
    entries: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class ParameterOf:
    """A parameter from which the loop makes constants."""

    block: str
    parameter: str
    entries: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class PeriodOf:
    """The period of a block whose constants the loop makes."""

    block: str


@dataclass(frozen=True, slots=True)
class StreamOf:
    """The random stream of a block."""

    block: str


@dataclass(frozen=True, slots=True)
class BasePeriod:
    """The period of the base tick."""


@dataclass(frozen=True, slots=True)
class SolverNumber:
    """A number that steps a continuous group."""

    solver: str
    number: str


@dataclass(frozen=True, slots=True)
class LaneOf:
    """Where a variable lives between the loops over the lanes; a field of it where it holds several numbers."""

    variable: str
    field: str = ""


@dataclass(frozen=True, slots=True)
class HardwareModel:
    """The address of a compiled model of hardware."""


@dataclass(frozen=True, slots=True)
class LargestOf:
    """The largest value so far of each state of a continuous group that is stepped to a tolerance."""

    solver: str


VectorOf: TypeAlias = Endpoint | LargestOf  # a buffer, or a wire with several entries
Moving: TypeAlias = WireOf | StateField | OverflowsOf
Given: TypeAlias = ConstantOf | ParameterOf | PeriodOf | StreamOf | BasePeriod | SolverNumber | LaneOf | HardwareModel
Key: TypeAlias = Moving | Given

_LIKE_MADE_UP = re.compile(r"_(_0)*\Z")


class DuplicateKeyError(KeyError):
    """A place that was taken already: a defect of the generator."""


def word(block: str) -> str:
    """The name of a block as part of a variable's; no block lies inside another, so that two never agree.

    >>> word("axis.mass")
    'axis__mass'
    """
    return block.replace(".", "__")


def variable(node: VectorOf) -> str:
    """The variable of a port, a buffer or a field, or of the largest values of a group.

    >>> variable(("axis.mass", "force")), variable(("mass", "c_")), variable(LargestOf("group_0"))
    ('axis__mass__force', 'mass__c__0', 'group_0_largest')
    """
    if isinstance(node, LargestOf):
        return f"{node.solver}_largest"
    return f"{word(node[0])}__{_told_apart(node[1])}"


def made_up(name: str, role: str) -> str:
    """A variable that the generator makes up beside a block's or an output's.

    >>> made_up("mass", "c")
    'mass__c_'
    """
    return f"{name}__{role}_"


def _told_apart(name: str) -> str:
    """A user's name so that it does not end as those that are made up do; two never become the same.

    >>> [_told_apart(name) for name in ("input", "c_", "c__0", "c_0")]
    ['input', 'c__0', 'c__0_0', 'c_0']
    """
    return f"{name}_0" if _LIKE_MADE_UP.search(name) else name
