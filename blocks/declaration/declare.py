"""Base class of blocks: typed parameters and ports, and pure functions registered on the class.

    class Gain(Block):
        \"\"\"Amplifier.\"\"\"
        gain: float = param("1", "Factor.", default=1.0)
        input = Input("V", "What is amplified.")

    @Gain.output("V")
    def output(p, input: float) -> float:
        \"\"\"The input times the gain.\"\"\"
        return p.gain * input

The first argument of every function is the block's constants (or its parameters, where it declares no `constants`);
the others are bound by name: `x` the state, buffers, inputs, and what the runner knows: `Meaning`;
in a block with `formats`, whose constants are in registers, also `p`, the parameters.
An output depends on an input in the same tick only if its function takes that input as an argument.
"""

import dataclasses
import typing
from collections.abc import Callable, Iterable, Iterator
from types import FunctionType
from typing import Any, ClassVar

from proofmass.blocks.declaration.decorators import OF_A_FUNCTION, of_a_function
from proofmass.blocks.declaration.facts import Requirements
from proofmass.blocks.declaration.kind import BlockType
from proofmass.blocks.declaration.parameter import param, read_parameters
from proofmass.blocks.declaration.ports import Buffer, BufferPort, Input, Port, Recording
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import UnitError, unit

__all__ = ["Block", "BlockType", "Buffer", "BufferPort", "Input", "Port", "Recording", "block", "param"]


class Block(metaclass=BlockType):
    """Base of every block: a frozen value of its parameters, which are its only attributes.

    >>> from typing import NamedTuple
    >>> from proofmass import Block, Buffer, Input, param
    >>> class Delay(Block):
    ...     'Output of `ticks` ticks ago.'
    ...
    ...     ticks: int = param("1", "Ticks of delay.", default=2, at_least=1, at_most=100)
    ...     input = Input("V", "What is delayed.")
    ...     line = Buffer("The last samples.", float, ("ticks",))
    >>> Delay(ticks=5).ticks, list(Delay.inputs), list(Delay.buffers)
    (5, ['input'], ['line'])
    """

    __slots__ = ("__dict__", "__weakref__", "_texts")  # values are in __dict__, quantities as they were written beside
    _texts: ClassVar[dict[str, str]]  # of each block, in its slot; so named, it is no parameter

    def __init__(self, /, *unnamed: object, **values: Any) -> None:
        kind = type(self)
        if unnamed:
            raise TypeError(_parameters_are_named(kind, unnamed))
        unknown = [
            Problem(
                message=f"{kind.__name__} has no such parameter",
                key=f"{kind.__name__}.{name}",
                got=name,
                hint=did_you_mean(name, kind.parameters, f"the parameters of {kind.__name__}"),
                path=(name,),
            )
            for name in values
            if name not in kind.parameters
        ]
        read, problems = read_parameters(kind.parameters, values, kind.__name__)
        vars(self).update(read)
        object.__setattr__(self, "_texts", {name: text for name, text in values.items() if isinstance(text, str)})
        problems = unknown + problems + list(_bad_units(self))
        if not problems and kind.requirements is not None:
            problems = list(_unmet(self, kind.requirements))
        if problems:
            raise ModelError(problems)

    def __setattr__(self, name: str, value: object) -> None:
        cure = f'graph.with_parameters({{"block.{name}": ...}}), or dataclasses.replace(block, {name}=...)'
        raise dataclasses.FrozenInstanceError(f"cannot assign to {name}: a block is a frozen value; {cure}")

    def __delattr__(self, name: str) -> None:
        raise dataclasses.FrozenInstanceError(f"cannot delete {name}: a block is a frozen value")

    def __getstate__(self) -> tuple[dict[str, Any], dict[str, str]]:
        return dict(vars(self)), self._texts

    def __setstate__(self, state: tuple[dict[str, Any], dict[str, str]]) -> None:
        vars(self).update(state[0])
        object.__setattr__(self, "_texts", state[1])

    def __eq__(self, other: object) -> bool:
        return vars(self) == vars(other) if type(other) is type(self) else NotImplemented

    def __hash__(self) -> int:
        return hash((type(self), *vars(self).values()))

    def __repr__(self) -> str:
        parameters = type(self).parameters
        changed = (f"{name}={value!r}" for name, value in vars(self).items() if value != parameters[name].default)
        return f"{type(self).__name__}({', '.join(changed)})"


@of_a_function
def block(unit: str, **named: Any) -> Callable[[Callable[..., Any]], type[Block]]:
    """Make a stateless block of one function.

    Inputs come by name with their unit, parameters by name with `param`::

        @block("V", voltage="V", threshold=param("V", "What is taken off.", default=0.1))
        def rectified(p, voltage: float) -> float:
            \"\"\"Absolute value of a voltage, less a threshold.\"\"\"
            return abs(voltage) - p.threshold

    `unit` is that of the output, and `named` are inputs and parameters. Raises `TypeError` for a
    unit, a default or an argument of the function that cannot be.

    >>> from proofmass import block, param
    >>> @block("V", voltage="V", threshold=param("V", "What is taken off.", default=0.1))
    ... def rectified(p, voltage: float) -> float:
    ...     'Absolute value of a voltage, less a threshold.'
    ...     return abs(voltage) - p.threshold
    >>> rectified(threshold="200 mV").threshold
    0.2
    """

    def make(function: Callable[..., Any]) -> type[Block]:
        if not isinstance(function, FunctionType):
            raise TypeError(f"{shown(function)} is not a function; {OF_A_FUNCTION}")
        name = "".join(part.title() for part in function.__name__.split("_"))
        parameters = {n: value for n, value in named.items() if isinstance(value, dataclasses.Field)}
        inputs = {n: Input(u, f"The {n}.") for n, u in named.items() if n not in parameters}
        kinds = {n: type(p.default) for n, p in parameters.items()}
        body: dict[str, Any] = {"__doc__": function.__doc__, "__module__": function.__module__}
        body |= {"__annotations__": kinds, **parameters, **inputs}
        made = typing.cast("type[Block]", BlockType(name, (Block,), body))
        made.output(unit)(function)
        return made

    return make


def _parameters_are_named(kind: type[Block], values: tuple[object, ...]) -> str:
    """Return what to write instead of parameters by their places."""
    if not kind.parameters:
        return f"{kind.__name__} has no parameters: write {kind.__name__}()"
    written = ", ".join(f"{name}={shown(value)}" for name, value in zip(kind.parameters, values, strict=False))
    return f"{kind.__name__}: parameters are named: write {kind.__name__}({written})"


# -- the values of a block -------------------------------------------------------------------------


def _bad_units(block: Block) -> Iterator[Problem]:
    """A parameter that ports name as their unit must be one."""
    for name, parameter in type(block).parameters.items():
        if parameter.kind is str and (name == "unit" or name.endswith("_unit")):
            try:
                unit(vars(block)[name])
            except UnitError as error:
                key = f"{type(block).__name__}.{name}"
                yield error.problem(key, vars(block)[name], path=(name,), expected="a unit")


def _unmet(block: Block, requirements: Requirements) -> Iterator[Problem]:
    """Yield a problem for each pair of a parameter and what is expected of it."""
    kind, pairs = type(block), requirements(block)
    for pair in pairs if isinstance(pairs, Iterable) and not isinstance(pairs, str) else [pairs]:
        match pair:
            case str(name), str(expected) if name in kind.parameters:
                refusal = Refusal("does not go with the other parameters")
                yield refusal.problem(f"{kind.__name__}.{name}", vars(block)[name], path=(name,), expected=expected)
            case _:
                code = getattr(requirements, "__code__", None)
                yield Problem(
                    message="the function of @requires must yield pairs: a parameter, and what is expected of it",
                    key=kind.__name__,
                    file=code.co_filename if code else "",
                    line=code.co_firstlineno if code else 0,
                    got=shown(pair),
                    hint=f'write yield "{next(iter(kind.parameters), "gain")}", "less than 1"',
                )
