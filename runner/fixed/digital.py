"""Digital blocks made ready to run: their functions over raw values, as the reference and as integer code.

Raw values have mantissas in the place of fixed-point values; wires, states, buffers and probes hold
them. A function is traced once (`proofmass.runner.fixed.trace`). Constants that `formats` names are
numbers of the run, in their registers; all other constants, and the parameters of a block that
declares none, are known to the trace and folded into the code.
"""

from collections import namedtuple
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, shape_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.fixed.block_formats import function_formats, state_formats
from proofmass.runner.fixed.integer_code import IntegerCode, integer_code
from proofmass.runner.fixed.step_formats import Formats, SteadyValue, filled, reference_step, storer
from proofmass.runner.fixed.trace import Traced, trace


@dataclass(frozen=True)
class DigitalStep:
    """A function of a digital block on raw values; reference and code take the constants first, the one needs none."""

    name: str
    function: Callable[..., Any]
    reference: Callable[..., Any]
    traced: Traced

    @property
    def overflows(self) -> bool:
        """True if a cast can saturate or wrap."""
        return self.traced.overflows.constant != 0

    @property
    def refuses(self) -> bool:
        """True if a cast can refuse."""
        return self.traced.refused.constant != 0

    @cached_property
    def code(self) -> IntegerCode:
        """The integer code; raises `TraceError` where 64 bits do not hold a value.

        Beside the result it returns a number that is not 0 where a cast saturated or wrapped, and
        one that is not 0 where a cast refused, only where they can be.
        """
        return self._code(self.traced)

    @cached_property
    def slope_code(self) -> IntegerCode:
        """The integer code for programs with slopes: what searches by signs leave over is in it."""
        if not self.traced.program.searches:
            return self.code
        return self._code(trace(self.function, self.traced.formats, refusals=True, rests=True))

    def _code(self, traced: Traced) -> IntegerCode:
        return integer_code(traced, [traced.lost] * self.overflows + [traced.refused] * self.refuses)


@dataclass(frozen=True)
class DigitalBlock:
    """A digital block at a period: raw constants, start and buffers, and its functions by name."""

    constants: Any
    start: Any
    buffers: Mapping[str, tuple[int, ...]]
    steps: Mapping[str, DigitalStep]

    @property
    def overflows(self) -> bool:
        """True if one of its values can saturate or wrap at all."""
        return any(step.overflows for step in self.steps.values())

    @cached_property
    def wide(self) -> bool:
        """True if its values exceed 64 bits: compiled code cannot run the block then."""
        try:
            return not all(step.code for step in self.steps.values())
        except ModelError:
            return True


def digital_block(name: str, block: Block, period: float, *, wide: bool = False) -> DigitalBlock:
    """The block called `name` in its graph; raises `ModelError` for what is wider than 64 bits, unless it may be."""
    try:
        constants = _prepared(block, period)
        if not wide:
            for step in constants.steps.values():
                _ = step.code
        return constants
    except ModelError as error:
        path = ("blocks", name)
        raise ModelError([replace(p, key=f"blocks.{name}.{p.key}", path=path) for p in error.problems]) from error


@lru_cache(maxsize=1024)
def _prepared(block: Block, period: float) -> DigitalBlock:
    constants: Any = block
    if "constants" in type(block).functions:
        behaviour = type(block).functions["constants"]
        constants = behaviour.function(block, *behaviour.named({"period": period}))
    registers = _registers(block, constants)
    formats = SteadyValue(block)
    raw: Any = _constants_class(type(block).__name__, ())()
    if constants is not block:
        formats = type(constants)(*(registers.get(f, SteadyValue(v)) for f, v in constants._asdict().items()))
        kept = _constants_class(type(block).__name__, tuple(registers))
        raw = kept(*(storer(each, f"c.{f}")(getattr(constants, f)) for f, each in registers.items()))
    state = state_formats(block)
    buffers = {name: [0] * shape_of(block, buffer)[0] for name, buffer in type(block).buffers.items()}
    start = filled(state, "x", lambda text, format: format(0) if format is bool else 0)
    if "start" in type(block).functions:
        behaviour = type(block).functions["start"]
        begin = reference_step(behaviour.function, function_formats(block, "start", behaviour, SteadyValue(block)))
        start = begin(None, *behaviour.named(buffers))
    functions = {**type(block).output_functions, **{n: b for n, b in type(block).functions.items() if n == "update"}}
    steps = {name: _step(block, name, b, formats, SteadyValue(constants)) for name, b in functions.items()}
    return DigitalBlock(raw, start, {name: tuple(held) for name, held in buffers.items()}, steps)


def _step(block: Block, name: str, behaviour: Behaviour, constants: Formats, known: SteadyValue) -> DigitalStep:
    """`known` are the constants with their values, for the reference."""
    traced = trace(behaviour.function, function_formats(block, name, behaviour, constants), refusals=True)
    reference = reference_step(behaviour.function, function_formats(block, name, behaviour, known))
    return DigitalStep(name, behaviour.function, reference, traced)


@lru_cache(maxsize=256)
def _constants_class(kind: str, fields: tuple[str, ...]) -> Any:
    made = namedtuple(f"{kind}Constants", fields)  # type: ignore[misc]
    made.__annotations__ = dict.fromkeys(fields, int)
    return made


def _registers(block: Block, constants: Any) -> dict[str, Formats]:
    """Formats of the constants that have one, by field; of a tuple of values one for each."""
    said = type(block).functions["formats"].function(block)
    registers: dict[str, Formats] = {}
    for field, value in () if constants is block else constants._asdict().items():
        if f"c.{field}" in said or "c" in said:
            if isinstance(value, FixedValue):
                registers[field] = format_of(block, f"c.{field}")
            elif isinstance(value, tuple) and value and all(isinstance(each, FixedValue) for each in value):
                registers[field] = (format_of(block, f"c.{field}"),) * len(value)
    return registers
