"""Decorators that register functions on a kind of block, one for each role of a function.

The decorators are attributes of the kind, as in `@Gain.output("V")`, and not of its blocks; see
`facts.py`.
"""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour, bound
from proofmass.blocks.declaration.decorators import bare, called
from proofmass.blocks.declaration.facts import Facts, Requirements
from proofmass.blocks.declaration.names import MOVING, refuse_taken, taken
from proofmass.blocks.declaration.parameter import fill
from proofmass.blocks.declaration.ports import DeclaredSize, NumberType, Port
from proofmass.blocks.declaration.problem import shown
from proofmass.blocks.declaration.unit_expressions import UnitError, unit

_Function = TypeVar("_Function", bound=Callable[..., Any])


class Registration(Facts):
    """A kind of block on which functions are registered."""

    @bare
    def formats(cls, function: _Function) -> _Function:
        """Register `formats(p) -> dict[str, Fixed]`: of fixed-point ports, buffers, state ("x") and constants ("c")."""
        cls.functions["formats"] = _bound(cls, function, set())
        return function

    @bare
    def constants(cls, function: _Function) -> _Function:
        """Register `constants(p, period) -> Constants`: for the loop; `period` may be left out."""
        _once(cls, cls.functions, "constants", _bound(cls, function, {"period"}))
        return function

    @bare
    def start(cls, function: _Function) -> _Function:
        """Register `start(p, buffers..., period) -> State`: the state at tick 0; without it of defaults, or zeros."""
        _once(cls, cls.functions, "start", _bound(cls, function, {*cls.buffers, "period"}))
        return function

    @bare
    def update(cls, function: _Function) -> _Function:
        """Register `update(c, x, buffers..., inputs...) -> State`: from tick to tick."""
        _once(cls, cls.functions, "update", _bound(cls, function, _in_the_loop(cls) - {"out"}))
        return function

    @called("linear=False")
    def derivative(cls, *, linear: bool) -> Callable[[_Function], _Function]:
        """Register `derivative(c, x, inputs...) -> State`: the block is continuous and the runner integrates it.

        Where it is `linear` in state and inputs, but for a constant, the step is exact. Only fields of
        type float are integrated; the others are modes, which events change.
        """

        def register(function: _Function) -> _Function:
            _once(cls, cls.functions, "derivative", _bound(cls, function, {"x", *cls.inputs, "time"}))
            cls.__declaration__.linear = linear
            return function

        return register

    @bare
    def fold(cls, function: _Function) -> _Function:
        """Register `fold(c, x) -> State`: the state of a continuous block in another form, at the
        end of each tick.

        An angle that grows loses digits: its whole turns are counted apart. Outputs are the same
        but for rounding.
        """
        if "derivative" not in cls.functions:
            raise TypeError(f"{cls.__name__}.fold: only continuous blocks have one; register the derivative before it")
        _once(cls, cls.functions, "fold", _bound(cls, function, {"x"}))
        return function

    @called("then=NEXT_STATE")
    def event(cls, *, then: Callable[..., Any]) -> Callable[[_Function], _Function]:
        """Register `clearance(c, x, inputs..., time) -> float`, above zero for as long as nothing happens.

        When it falls to zero or below, the runner finds the instant and calls `then(c, x,
        inputs..., time) -> State`, after which the clearance must be above zero again: a mode in
        the state, or the sign of a velocity, says so.
        """

        def register(function: _Function) -> _Function:
            known = {"x", *cls.inputs, "time"}
            _once(cls, cls.events, function.__name__, (_bound(cls, function, known), _bound(cls, then, known)))
            return function

        return register

    @bare
    def corner(cls, function: _Function) -> _Function:
        """Register `beyond(c, inputs..., time) -> float`, whose sign tells on which side of a
        corner the outputs are, or `passed(c, time) -> int`, how many corners there were so far:
        none is missed, however many a step has.

        Within a group of continuous blocks steps end at the instant at which the sign changes: no
        method of integration is as accurate as it says across a corner or a jump.
        """
        _once(cls, cls.corners, function.__name__, _bound(cls, function, {*cls.inputs, "time"}))
        return function

    @bare
    def requires(cls, function: Requirements) -> Requirements:
        """Register `requires(p)`, which yields (parameter, what is expected) where parameters do not go together."""
        cls.__declaration__.requirements = function
        return function

    @called('"V"')
    def output(
        cls,
        unit: str,
        *,
        shape: tuple[DeclaredSize, ...] = (),
        dtype: NumberType | None = None,
        every: DeclaredSize = 1,
        no_value: str = "",
    ) -> Callable[[_Function], _Function]:
        """Register the output port the function computes; its name, dtype and doc are the port's.

        With a `shape` the function writes into `out` and `dtype` is given here. `every` makes the
        port tick once in so many ticks of its block. A function that returns NaN where physics ends
        has the run end there; `no_value` then says what has happened, and what to do.
        """

        def register(function: _Function) -> _Function:
            name = function.__name__
            refuse_taken(cls, name)
            _refuse_twice(cls, name)
            computed = _bound(cls, function, _in_the_loop(cls))
            kind = dtype or computed.returns
            if kind not in (float, int, bool, FixedValue) or bool(shape) != (Meaning.OUT in computed.meanings):
                raise TypeError(
                    f"{cls.__name__}.{name} must return float, int, bool or FixedValue, or write its entries into out"
                )
            refuse_no_unit(cls, name, unit)
            doc = inspect.getdoc(function) or ""
            cls.outputs[name] = Port(name, unit, doc, kind, shape, None, every, no_value)
            cls.output_functions[name] = computed
            return function

        return register


def refuse_no_unit(kind: Facts, name: str, text: str) -> None:
    """Raise TypeError where a block of the user's own names an unknown unit; tests see to those of the library."""
    if kind.__module__.startswith("proofmass.blocks."):
        return
    if not isinstance(text, str):
        raise TypeError(f'{kind.__name__}.{name}: the unit comes first, as a text such as "V"; got {shown(text)}')
    texts = {n: p.default for n, p in kind.parameters.items() if p.kind is str}
    try:
        unit(fill(text, texts))
    except UnitError as error:
        raise TypeError(f"{kind.__name__}.{name}: {error}" + (f"; {error.hint}" if error.hint else "")) from None


def _refuse_twice(kind: Facts, name: str) -> None:
    """Raise TypeError where something else of the block has the name of an output."""
    if name in MOVING:
        raise taken(kind, name, f"{name} is {MOVING[name]}")
    named = {"a parameter": [*kind.parameters], "an input": [*kind.inputs], "a buffer": [*kind.buffers]}
    for what, names in (named | {"an output": [*kind.outputs]}).items():
        if name in names:
            raise taken(kind, name, f"it is the name of {what} of the block")


def _once(kind: Facts, registered: dict[str, Any], name: str, entry: object) -> None:
    """Register a function; raises TypeError where there is one already, which would be left out."""
    if name in registered:
        raise TypeError(f"{kind.__name__}.{name}: there is one already; a block has one {name}")
    registered[name] = entry


def _in_the_loop(kind: Facts) -> set[str]:
    """Arguments of functions that run in the loop; where `formats` come first, the parameters are one of them."""
    left_out = {Meaning.PERIOD} if "formats" in kind.functions else {Meaning.PERIOD, Meaning.PARAMETERS}
    fixed = {meaning.argument for meaning in Meaning if meaning.argument and meaning not in left_out}
    return {*fixed, *kind.buffers, *kind.inputs}


def _bound(kind: Facts, function: Callable[..., Any], known: set[str]) -> Behaviour:
    return bound(kind.__name__, function, known, kind.inputs, kind.buffers)
