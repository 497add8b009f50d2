"""Checks of what a block declares: documents, units, bounds."""

import math
import random
import re
from collections.abc import Iterator
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of, unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.ports import BufferPort, Port
from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.blocks.declaration.unit_expressions import UnitError, unit
from proofmass.runner.contract.drawn import random_value
from proofmass.runner.contract.places import problem
from proofmass.runner.contract.verdict import ContractVerdict, verdict
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.output.counts import count
from proofmass.runner.plan.constants import constants_of, start_of
from proofmass.runner.planning.plan import numbers_in

PERIOD = 1e-4  # seconds
_NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_DRAWN = 20  # sets of parameters
_BEYOND = 1e-9  # of the size of a bound


def documents(kind: type[Block]) -> ContractVerdict:
    """The block, its parameters and ports are described, and named as the library's are."""
    declared: dict[str, Parameter | Port | BufferPort] = {
        **kind.parameters,
        **kind.inputs,
        **kind.outputs,
        **kind.buffers,
    }
    ports = [count(len(kind.inputs), "input"), count(len(kind.outputs), "output")]
    detail = ", ".join(["docstring", count(len(kind.parameters), "parameter"), *ports])

    def problems() -> Iterator[Problem]:
        summary = (kind.__doc__ or "").strip()
        if not summary or summary.startswith(f"{kind.__name__}("):  # written by dataclasses
            yield problem(kind, "", "it has no docstring", hint=f'class {kind.__name__}(Block): """What it is."""')
        elif not summary.partition("\n")[0].endswith("."):
            yield problem(kind, "", "its docstring does not begin with a sentence", got=summary.partition("\n")[0])
        if not kind.outputs:
            yield problem(kind, "", "it has no output, so it does nothing", hint=f'@{kind.__name__}.output("V")')
        for name, thing in declared.items():
            if not thing.doc.strip():
                hint = "write a docstring" if name in kind.outputs else "say what it is, after the unit"
                yield problem(kind, name, "it has no description", hint=hint)
            if not _NAME.fullmatch(name):
                expected = "lower case, words joined by _, as in cut_off"
                yield problem(kind, name, "its name is not written as others are", got=name, expected=expected)

    return verdict("documents", problems(), detail)


def units(kind: type[Block]) -> ContractVerdict:
    """Every port and every parameter that is a number has a unit, whichever the block is given."""
    measured = [*kind.inputs.values(), *kind.outputs.values()]
    measured += [p for p in kind.parameters.values() if p.kind in (float, tuple)]  # type: ignore[misc]
    free = [name for name, p in kind.parameters.items() if p.kind is str and not p.choices]
    blocks = [kind(), *(made(kind, {name: "m/s"}) for name in free)]

    def problems() -> Iterator[Problem]:
        for thing in measured:
            for block in filter(None, blocks):
                text = unit_of(block, thing)
                try:
                    unit(text)
                    wrong = "" if text else "it has no unit"
                    hint = 'write "1" where it has none'
                except UnitError as error:
                    wrong, hint = str(error), error.hint
                if wrong:
                    yield problem(kind, thing.name, wrong, got=shown(text), hint=hint)
                    break

    return verdict("units", problems(), f"{count(len(measured), 'unit')} of ports and parameters")


def bounds(kind: type[Block]) -> ContractVerdict:
    """Values beyond the bounds are refused, and with any within them the block can start."""
    dice, tried = random.Random(kind.__name__), list[dict[str, Any]]()
    wrong: dict[str, Problem] = {}
    for name, parameter in kind.parameters.items():
        for value in outside(parameter).values():
            if made(kind, {name: value}) is not None:
                wrong[name] = problem(kind, name, "it takes a value beyond its bounds", got=shown(value))
        tried += [{name: value} for value in within(parameter)]
    tried += [{n: random_value(p, dice) for n, p in kind.parameters.items()} for _ in range(_DRAWN)]
    for values in tried:
        error = _fails(kind, values)
        if error and error not in wrong:
            said = ", ".join(f"{name} = {shown(value)}" for name, value in values.items())
            hint = "narrow the bounds of the parameter, or refuse it in `requires`"
            wrong[error] = problem(kind, next(iter(values)), error, got=said, hint=hint)
    bounded = sum(bool(p.bounds()) for p in kind.parameters.values())
    detail = f"{count(bounded, 'parameter')} with bounds; started with {count(len(tried) + 1, 'set')} of parameters"
    return verdict("bounds", list(wrong.values()), detail)


def outside(parameter: Parameter) -> dict[float, float | int]:
    """Return for each bound of a parameter a value just beyond it."""
    if parameter.kind not in (int, float):
        return {}
    ends = {parameter.above: 0, parameter.below: 0, parameter.at_least: -1, parameter.at_most: 1}
    return {bound: _further(parameter, bound, way) for bound, way in ends.items() if bound is not None}


def within(parameter: Parameter) -> list[float | int]:
    """Return values at the bounds of a parameter, or just inside where it excludes it."""
    if parameter.kind not in (int, float):
        return []
    ends = [bound for bound in (parameter.at_least, parameter.at_most) if bound is not None]
    wide = [parameter.kind(factor * parameter.default) for factor in (1e-3, 1e3)]
    return [value for value in (*map(parameter.kind, ends), *wide) if parameter.inside(value)]


def _further(parameter: Parameter, bound: float, way: int) -> float | int:
    step = 1 if parameter.kind is int else _BEYOND * max(abs(bound), 1.0)
    return parameter.kind(bound + way * step)  # type: ignore[no-any-return]


def made(kind: type[Block], values: dict[str, Any]) -> Block | None:
    """The block with some parameters set, or None if they are refused."""
    try:
        return kind(**values)
    except ModelError:
        return None


def _fails(kind: type[Block], values: dict[str, Any]) -> str:
    """Return why a block with these parameters cannot start, or ""."""
    try:
        block = kind(**values)
        if kind.has_formats():
            return ""
        constants = constants_of(block, block, PERIOD)
        if not all(map(math.isfinite, numbers_in(constants or ()))):
            return "constants gives a number that is not finite"
        sizes = {name: math.prod(shape_of(block, buffer)) for name, buffer in kind.buffers.items()}
        start_of(block, {n: [held_as(b.dtype)(0)] * sizes[n] for n, b in kind.buffers.items()}, PERIOD)
    except ModelError:
        return ""
    except Exception as error:
        return f"it cannot start: {type(error).__name__}: {error}"
    return ""
