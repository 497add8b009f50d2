"""Facts of a kind of block: its declaration, and all that follows from it.

The facts are attributes of the kind, as in `Gain.inputs`, and not of its blocks: an attribute of a
block is a parameter and nothing else, so that parameters and ports may be called `inputs` or
`size`. Of a block, ask `type(block).inputs`.
"""

import dataclasses
import types
import typing
from collections import namedtuple
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.ports import BufferPort, Port

Requirements = Callable[[Any], Iterator[tuple[str, str]]]
_NUMERIC: dict[type, Any] = {float: float, int: int, bool: bool, tuple: tuple[float, ...]}


@dataclasses.dataclass
class Declaration:
    """Parameters, inputs and buffers from the class body; the rest as functions register."""

    name: str
    parameters: dict[str, Parameter]
    inputs: dict[str, Port]
    buffers: dict[str, BufferPort]
    requirements: Requirements | None
    linear: bool
    outputs: dict[str, Port] = dataclasses.field(default_factory=dict)
    functions: dict[str, Behaviour] = dataclasses.field(default_factory=dict)
    output_functions: dict[str, Behaviour] = dataclasses.field(default_factory=dict)
    events: dict[str, tuple[Behaviour, Behaviour]] = dataclasses.field(default_factory=dict)
    corners: dict[str, Behaviour] = dataclasses.field(default_factory=dict)

    @cached_property
    def parameters_class(self) -> type:
        """The NamedTuple of the numbers and lists of numbers among the parameters."""
        numeric = {name: _NUMERIC[p.kind] for name, p in self.parameters.items() if p.kind in _NUMERIC}
        record = namedtuple(f"{self.name}Parameters", list(numeric))  # type: ignore[misc]
        record.__annotations__ = numeric
        return record


class Facts(type):
    """A kind of block: a class with the facts that are declared of it."""

    __declaration__: Declaration

    # -- as declared -------------------------------------------------------------------------------

    @property
    def parameters(cls) -> dict[str, Parameter]:
        """Parameters by name."""
        return cls.__declaration__.parameters

    @property
    def inputs(cls) -> dict[str, Port]:
        """Input ports by name."""
        return cls.__declaration__.inputs

    @property
    def outputs(cls) -> dict[str, Port]:
        """Output ports by name."""
        return cls.__declaration__.outputs

    @property
    def buffers(cls) -> dict[str, BufferPort]:
        """Vectors of state by name."""
        return cls.__declaration__.buffers

    @property
    def functions(cls) -> dict[str, Behaviour]:
        """Registered functions by role: formats, constants, start, update, derivative, fold."""
        return cls.__declaration__.functions

    @property
    def output_functions(cls) -> dict[str, Behaviour]:
        """The function of each output port."""
        return cls.__declaration__.output_functions

    @property
    def events(cls) -> dict[str, tuple[Behaviour, Behaviour]]:
        """Events: pairs of the clearance that falls to zero and the function that follows."""
        return cls.__declaration__.events

    @property
    def corners(cls) -> dict[str, Behaviour]:
        """Functions that change sign where the outputs have a corner or a jump."""
        return cls.__declaration__.corners

    @property
    def requirements(cls) -> Requirements | None:
        """The function that yields parameters that do not go together."""
        return cls.__declaration__.requirements

    @property
    def linear(cls) -> bool:
        """True if a continuous block's derivative is linear in state and inputs."""
        return cls.__declaration__.linear

    # -- what follows ------------------------------------------------------------------------------

    def continuous(cls) -> bool:
        """Return whether the runner integrates the block between ticks."""
        return "derivative" in cls.functions or bool(cls.events)

    def has_formats(cls) -> bool:
        """Return whether its functions work on `FixedValue`: it has formats, but no float ports."""
        ports = (*cls.inputs.values(), *cls.outputs.values())
        return "formats" in cls.functions and all(port.dtype is not float for port in ports)

    def feedthrough(cls, port: str) -> tuple[str, ...]:
        """Inputs that reach this output within the same sample: its function's arguments."""
        return tuple(name for name in cls.output_functions[port].arguments if name in cls.inputs)

    def state_class(cls) -> type | None:
        """The NamedTuple of the block's state, or None for a block without one."""
        moving = [cls.functions[name] for name in ("update", "derivative", "start") if name in cls.functions]
        moving += [then for _, then in cls.events.values()]
        return next((typing.cast(type, b.returns) for b in moving if b.returns is not None), None)

    def constants_class(cls) -> type:
        """The NamedTuple of the first argument of its functions: the constants, or else the numeric parameters."""
        if "constants" in cls.functions:
            return typing.cast(type, cls.functions["constants"].returns)
        return cls.parameters_class()

    def parameters_class(cls) -> type:
        """A NamedTuple of the numbers and lists of numbers among the parameters, as `constants` sees driven ones."""
        return cls.__declaration__.parameters_class

    def drivable(cls, parameter: str) -> bool:
        """Return whether a wire may drive the parameter.

        It is a number that the loop can take anew in every tick, and that means the same then.
        """
        return cls.taken_in_the_loop(parameter) and not cls.parameters[parameter].not_driven

    def taken_in_the_loop(cls, parameter: str) -> bool:
        """Return whether the loop can compute constants from the parameter: no start, requirement or size uses it."""
        if cls.has_formats() or cls.parameters[parameter].kind is not float:
            return False
        start, constants = (cls.functions.get(name) for name in ("start", "constants"))
        once = [f for f in (start and start.function, cls.requirements) if f]
        sized: tuple[Port | BufferPort, ...] = (*cls.outputs.values(), *cls.buffers.values())
        once += [size for port in sized for size in port.shape if callable(size)]
        no_numbers = {name for name, p in cls.parameters.items() if p.kind in (tuple, Fixed)}
        from_these = constants is not None and no_numbers & set(constants.function.__code__.co_names)
        return not from_these and not any(parameter in _names(f) for f in once)


def _names(function: Any) -> set[str]:
    """Names that a function uses, with those of the functions that it calls."""
    names, waiting = set[str](), [function]
    seen: set[Any] = set()
    while waiting:
        each = waiting.pop()
        if isinstance(each, types.FunctionType) and each not in seen:
            seen.add(each)
            used = _names_of_code(each.__code__)
            names |= used
            waiting += [each.__globals__.get(name) for name in used]
    return names


def _names_of_code(code: types.CodeType) -> set[str]:
    inner = (_names_of_code(constant) for constant in code.co_consts if isinstance(constant, types.CodeType))
    return set(code.co_names).union(*inner)
