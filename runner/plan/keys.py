"""Keys of places in the memory of a generated loop, each of its own type, and the names of their variables.

Two keys are equal only if type and names agree, whatever names a user chooses. A variable of the
loop is called `block__port`. Names that the generator makes up end in an underscore, as
`block__port__next_`; a user's never do.
"""

import re
from dataclasses import dataclass
from typing import TypeAlias

from proofmass.graphs.model.graph import Endpoint


@dataclass(frozen=True, slots=True)
class WireOf:
    """The value of an output."""

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
    """A number that the solver of a continuous group uses."""

    solver: str
    number: str


@dataclass(frozen=True, slots=True)
class HardwareModel:
    """The address of a compiled model of hardware."""


@dataclass(frozen=True, slots=True)
class LargestOf:
    """The largest value so far of each state of a continuous group with a tolerance."""

    solver: str


VectorOf: TypeAlias = Endpoint | LargestOf  # a buffer, or a wire with several entries
Moving: TypeAlias = WireOf | StateField | OverflowsOf
Given: TypeAlias = ConstantOf | ParameterOf | PeriodOf | StreamOf | BasePeriod | SolverNumber | HardwareModel

_LIKE_MADE_UP = re.compile(r"_(_0)*\Z")


class DuplicateKeyError(KeyError):
    """Two numbers have the same key: a defect of the generator."""


def word(block: str) -> str:
    """The name of a block as part of a variable's name; different blocks never get the same.

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


def _told_apart(name: str) -> str:
    """Change a user's name so that it does not end like made-up names; different names stay different.

    >>> [_told_apart(name) for name in ("input", "c_", "c__0", "c_0")]
    ['input', 'c__0', 'c__0_0', 'c_0']
    """
    return f"{name}_0" if _LIKE_MADE_UP.search(name) else name
