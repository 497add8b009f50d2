"""How a block is written: a class of typed parameters and ports, and pure functions registered on it.

    class Gain(Block):
        \"\"\"Amplifier.\"\"\"
        gain: float = param("1", "Factor.", default=1.0)
        input = Input("V", "What is amplified.")

    @Gain.output("V")
    def output(p, input: float) -> float:
        \"\"\"The input times the gain.\"\"\"
        return p.gain * input

The first argument of every function is the block's constants (or its parameters, where it declares no `constants`);
the others are bound by name: `x` the state, buffers, inputs, and what the runner knows: `Meaning`; in a block with
`formats`, whose constants are in registers, also `p`, the parameters.
An output that names an input depends on it in the same sample; one that does not, does not.
"""

import dataclasses
import dis
import inspect
import typing
from collections import namedtuple
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, TypeVar, dataclass_transform

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.arguments import Meaning, meaning_of
from proofmass.blocks.declaration.parameter import Parameter, declared, fill, param, read_parameters
from proofmass.blocks.declaration.ports import (
    Buffer,
    BufferPort,
    Input,
    Number,
    Port,
    Recording,
    Size,
    refuse_taken,
)
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean, shown
from proofmass.blocks.declaration.units import UnitError, unit

__all__ = ["Block", "Buffer", "BufferPort", "Input", "Port", "Recording", "block", "param"]

Function = TypeVar("Function", bound=Callable[..., Any])

_ROLES = ("formats", "constants", "start", "update", "derivative")  # the functions beside outputs, told apart by name


@dataclasses.dataclass(frozen=True)
class Behaviour:
    """A registered function, and the names of its arguments after the first with what they mean."""

    function: Callable[..., Any]
    arguments: tuple[str, ...]
    meanings: tuple[Meaning, ...]
    returns: Any
    reads_constants: bool  # some outputs are a field of the state and nothing else


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(param,))
class Block:
    """Base of every block; a subclass is a frozen dataclass of its parameters."""

    parameters: ClassVar[dict[str, Parameter]] = {}
    inputs: ClassVar[dict[str, Port]] = {}
    outputs: ClassVar[dict[str, Port]] = {}
    buffers: ClassVar[dict[str, BufferPort]] = {}
    functions: ClassVar[dict[str, Behaviour]] = {}  # formats, constants, start, update, derivative
    output_functions: ClassVar[dict[str, Behaviour]] = {}
    linear: ClassVar[bool] = False  # of a continuous block: its derivative is linear in state and inputs
    events: ClassVar[dict[str, tuple[Behaviour, Behaviour]]] = {}  # what falls to zero, and what happens then
    corners: ClassVar[dict[str, Behaviour]] = {}  # what changes its sign where the outputs have a corner or a jump
    requirements: ClassVar[Callable[[Any], Iterator[tuple[str, str]]] | None] = None

    def __init_subclass__(cls) -> None:
        cls.outputs, cls.functions, cls.output_functions, cls.events, cls.corners = {}, {}, {}, {}, {}
        dataclasses.dataclass(frozen=True, init=False, repr=False)(cls)
        hints = typing.get_type_hints(cls)
        cls.parameters = {f.name: _parameter(cls, f, hints[f.name]) for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
        units = {p.name: p.unit for p in cls.parameters.values() if p.unit} | {
            p.name: p.unit for p in cls.inputs.values()
        }
        for name, text in units.items():
            _refuse_no_unit(cls, name, text)

    def __init__(self, /, **values: Any) -> None:
        kind = type(self)
        unknown = [
            Problem(
                message=f"{kind.__name__} has no such parameter",
                key=f"{kind.__name__}.{name}",
                got=name,
                hint=did_you_mean(name, kind.parameters, "parameter"),
                path=(name,),
            )
            for name in values
            if name not in kind.parameters
        ]
        read, problems = read_parameters(kind.parameters, values, kind.__name__)
        for name, value in read.items():
            object.__setattr__(self, name, value)
        problems = unknown + problems + self._bad_units()
        if not problems and kind.requirements is not None:
            problems = [
                Problem(
                    message="does not go with the other parameters",
                    key=f"{kind.__name__}.{name}",
                    got=shown(getattr(self, name)),
                    expected=expected,
                    path=(name,),
                )
                for name, expected in kind.requirements(self)
            ]
        if problems:
            raise ModelError(problems)

    def _bad_units(self) -> list[Problem]:
        """A parameter that ports name as their unit must be one."""
        problems = []
        for name, parameter in self.parameters.items():
            if parameter.kind is str and _names_a_unit(name):
                try:
                    unit(getattr(self, name))
                except UnitError as error:
                    key = f"{type(self).__name__}.{name}"
                    problems.append(
                        Problem(
                            message=str(error),
                            key=key,
                            got=shown(getattr(self, name)),
                            expected="a unit",
                            hint=error.hint,
                            path=(name,),
                        )
                    )
        return problems

    def __repr__(self) -> str:
        changed = (f"{n}={getattr(self, n)!r}" for n, p in self.parameters.items() if getattr(self, n) != p.default)
        return f"{type(self).__name__}({', '.join(changed)})"

    # -- facts of an instance ------------------------------------------------------------------------------------

    def unit_of(self, what: Port | Parameter) -> str:
        """The unit of a port or parameter, with the block's own unit parameters put in."""
        if "{" not in what.unit:
            return what.unit
        return fill(what.unit, {n: getattr(self, n) for n, p in self.parameters.items() if p.kind is str})

    def size(self, size: Size) -> int:
        """A size as a number: itself, the value of an integer parameter, or the length of a list parameter."""
        if isinstance(size, int):
            return size
        if callable(size):
            return size(self)
        value = getattr(self, size)
        return len(value) if isinstance(value, tuple) else int(value)

    def shape_of(self, what: "Port | BufferPort") -> tuple[int, ...]:
        """The shape of a port or buffer as numbers."""
        return tuple(self.size(size) for size in what.shape)

    def format_of(self, what: str) -> Fixed:
        """The format of a fixed-point port or buffer, or of a field as in "x.total"; `formats` may say "x" for all."""
        formats = self.functions["formats"].function(self) if "formats" in self.functions else {}
        found = formats.get(what) or formats.get(what.partition(".")[0])
        if found is None:
            key = f"{type(self).__name__}.formats"
            hint = f'return it there: {{"{what}": Fixed(16, 12)}}'
            raise ModelError([Problem(message=f"the format of {what} is not said", key=key, hint=hint)])
        return typing.cast(Fixed, found)

    # -- facts of a class ----------------------------------------------------------------------------------------

    @classmethod
    def continuous(cls) -> bool:
        """Whether the runner integrates the block between ticks."""
        return "derivative" in cls.functions or bool(cls.events)

    @classmethod
    def digital(cls) -> bool:
        """Whether its functions work on `FixedValue`: it has formats, and no port carries floating-point numbers."""
        ports = (*cls.inputs.values(), *cls.outputs.values())
        return "formats" in cls.functions and all(port.dtype is not float for port in ports)

    @classmethod
    def feedthrough(cls, port: str) -> tuple[str, ...]:
        """Inputs that reach this output within the same sample: the arguments its function names."""
        return tuple(name for name in cls.output_functions[port].arguments if name in cls.inputs)

    @classmethod
    def state_class(cls) -> type | None:
        """The NamedTuple of the block's state, or None for a block without one."""
        moving = [cls.functions[name] for name in ("update", "derivative", "start") if name in cls.functions]
        moving += [then for _, then in cls.events.values()]
        return next((typing.cast(type, b.returns) for b in moving if b.returns is not None), None)

    @classmethod
    def constants_class(cls) -> type:
        """The NamedTuple that the block's functions get first: its constants, or else its numeric parameters."""
        if "constants" in cls.functions:
            return typing.cast(type, cls.functions["constants"].returns)
        return cls.parameters_class()

    @classmethod
    def parameters_class(cls) -> type:
        """A NamedTuple of the numbers and lists of numbers among the parameters, as `constants` sees driven ones."""
        if "_parameters_class" not in cls.__dict__:
            kinds = {float: float, int: int, bool: bool, tuple: tuple[float, ...]}
            numeric = {n: kinds[p.kind] for n, p in cls.parameters.items() if p.kind in kinds}
            made = namedtuple(f"{cls.__name__}Parameters", list(numeric))  # type: ignore[misc]
            made.__annotations__ = numeric
            cls._parameters_class = made  # type: ignore[attr-defined]
        return typing.cast(type, cls.__dict__["_parameters_class"])

    @classmethod
    def drivable(cls, parameter: str) -> bool:
        """Whether a wire may drive the parameter: a number that the loop can take anew in every tick, and that means
        the same then."""
        return cls.taken_in_the_loop(parameter) and not cls.parameters[parameter].not_driven

    @classmethod
    def taken_in_the_loop(cls, parameter: str) -> bool:
        """Whether constants can be computed in the loop from the parameter: a number that no start or requirement
        uses."""
        if cls.digital() or cls.parameters[parameter].kind is not float:
            return False
        start, constants = (cls.functions.get(name) for name in ("start", "constants"))
        once = [f for f in (start and start.function, cls.requirements) if f]
        no_numbers = {name for name, p in cls.parameters.items() if p.kind in (tuple, Fixed)}
        from_these = constants is not None and no_numbers & set(constants.function.__code__.co_names)
        return not from_these and not any(parameter in f.__code__.co_names for f in once)

    # -- registration --------------------------------------------------------------------------------------------

    @classmethod
    def _bound(cls) -> set[str]:
        """Arguments of functions that run in the loop; where `formats` come first, the parameters are one of them."""
        fixed = {Meaning.STATE, Meaning.TIME, Meaning.TICK, Meaning.DEVIATE, Meaning.OUT}
        fixed |= {Meaning.PARAMETERS} if "formats" in cls.functions else set()
        return {*(meaning.argument for meaning in fixed), *cls.buffers, *cls.inputs}

    @classmethod
    def formats(cls, function: Function) -> Function:
        """Register `formats(p) -> dict[str, Fixed]`: of fixed-point ports, buffers, state ("x") and constants ("c")."""
        cls.functions["formats"] = _behaviour(cls, function, set())
        return function

    @classmethod
    def constants(cls, function: Function) -> Function:
        """Register `constants(p, period) -> Constants`: what the loop needs, from the parameters."""
        cls.functions["constants"] = _behaviour(cls, function, {"period"})
        return function

    @classmethod
    def start(cls, function: Function) -> Function:
        """Register `start(p, buffers...) -> State`: the state at tick 0; without it every field starts at zero."""
        cls.functions["start"] = _behaviour(cls, function, set(cls.buffers))
        return function

    @classmethod
    def update(cls, function: Function) -> Function:
        """Register `update(c, x, buffers..., inputs...) -> State`: from this tick to the block's next."""
        cls.functions["update"] = _behaviour(cls, function, cls._bound() - {"out"})
        return function

    @classmethod
    def derivative(cls, *, linear: bool) -> Callable[[Function], Function]:
        """Register `derivative(c, x, inputs...) -> State`: the block is continuous and the runner integrates it.

        Only fields of type float are integrated; the others are modes, which events change.
        """

        def register(function: Function) -> Function:
            cls.functions["derivative"] = _behaviour(cls, function, {"x", *cls.inputs, "time"})
            cls.linear = linear
            return function

        return register

    @classmethod
    def event(cls, *, then: Callable[..., Any]) -> Callable[[Function], Function]:
        """Register `clearance(c, x, inputs..., time) -> float`, above zero for as long as nothing happens.

        When it falls to zero or below, the runner finds the instant and calls `then(c, x, inputs..., time) -> State`,
        after which the clearance must be above zero again: a mode in the state, or the sign of a velocity, says so.
        """

        def register(function: Function) -> Function:
            known = {"x", *cls.inputs, "time"}
            cls.events[function.__name__] = _behaviour(cls, function, known), _behaviour(cls, then, known)
            return function

        return register

    @classmethod
    def corner(cls, function: Function) -> Function:
        """Register `beyond(c, inputs..., time) -> float`, whose sign tells on which side of a corner the outputs are.

        Within a group of continuous blocks steps end at the instant at which the sign changes: no method of
        integration is as accurate as it says across a corner or a jump.
        """
        cls.corners[function.__name__] = _behaviour(cls, function, {*cls.inputs, "time"})
        return function

    @classmethod
    def requires(cls, function: Function) -> Function:
        """Register `requires(p)`, which yields (parameter, what is expected) where parameters do not go together."""
        cls.requirements = staticmethod(function)
        return function

    @classmethod
    def output(
        cls,
        unit: str,
        *,
        shape: tuple[Size, ...] = (),
        dtype: Number | None = None,
        every: Size = 1,
        no_value: str = "",
    ) -> Callable[[Function], Function]:
        """Register the output port that the function computes; its name, dtype and doc are the port's.

        With a `shape` the function writes into `out` and `dtype` is given here. `every` makes the port tick once
        in so many ticks of its block. A function that returns NaN where physics ends has the run end there;
        `no_value` then says what has happened, and what to do.
        """

        def register(function: Function) -> Function:
            name = function.__name__
            mine = {"function": _ROLES, "parameter": cls.parameters, "input": cls.inputs, "buffer": cls.buffers}
            for what, names in (mine | {"output": cls.outputs}).items():
                refuse_taken(
                    cls, name, names, f"it is the name of {'an' if what[0] in 'io' else 'a'} {what} of the block"
                )
            behaviour = _behaviour(cls, function, cls._bound())
            kind = dtype or behaviour.returns
            if kind not in (float, int, bool, FixedValue) or bool(shape) != (Meaning.OUT in behaviour.meanings):
                raise TypeError(
                    f"{cls.__name__}.{name} must return float, int, bool or FixedValue, or write its entries into out"
                )
            _refuse_no_unit(cls, name, unit)
            doc = inspect.getdoc(function) or ""
            cls.outputs[name] = Port(name, unit, doc, kind, shape, None, every, no_value)
            cls.output_functions[name] = behaviour
            return function

        return register


def block(unit: str, **named: Any) -> Callable[[Callable[..., Any]], type[Block]]:
    """Make a stateless block of one function: inputs by name with their unit, parameters by name with `param`.

    @block("V", voltage="V", threshold=param("V", "What is taken off.", default=0.1))
    def rectified(p, voltage: float) -> float:
        \"\"\"Absolute value of a voltage, less a threshold.\"\"\"
        return abs(voltage) - p.threshold
    """

    def make(function: Callable[..., Any]) -> type[Block]:
        name = "".join(part.title() for part in function.__name__.split("_"))
        parameters = {n: value for n, value in named.items() if isinstance(value, dataclasses.Field)}
        inputs = {n: Input(u, f"The {n}.") for n, u in named.items() if n not in parameters}
        kinds = {n: type(p.default) for n, p in parameters.items()}
        body: dict[str, Any] = {"__doc__": function.__doc__, "__module__": function.__module__}
        body |= {"__annotations__": kinds, **parameters, **inputs}
        made = typing.cast("type[Block]", type(name, (Block,), body))
        made.output(unit)(function)
        return made

    return make


def _parameter(owner: type, field: "dataclasses.Field[Any]", kind: Any) -> Parameter:
    refuse_taken(owner, field.name, Block.__dict__)
    return declared(owner.__name__, field, kind)


def _behaviour(owner: type[Block], function: Callable[..., Any], known: set[str]) -> Behaviour:
    names = list(inspect.signature(function).parameters)
    returns = function.__annotations__.get("return")
    if isinstance(returns, str):
        returns = typing.get_type_hints(function)["return"]
    if hasattr(returns, "_fields") and any(
        isinstance(kind, str | typing.ForwardRef) for kind in returns.__annotations__.values()
    ):
        returns.__annotations__ = typing.get_type_hints(returns)
    unknown = [name for name in names[1:] if name not in known]
    if names and names[0] in {*known, *owner.inputs, *owner.buffers} - {"p", "c"}:
        raise TypeError(
            f"{owner.__name__}.{function.__name__}: the first argument is the constants, whatever it is called; "
            f"write def {function.__name__}(c, {', '.join(names)})"
        )
    if not names or unknown:
        hint = did_you_mean(unknown[0], known, "argument") if unknown else "the first argument is the constants"
        raise TypeError(f"{owner.__name__}.{function.__name__}: cannot bind the argument {unknown or names}; {hint}")
    reads_constants = any(step.argval == names[0] for step in dis.get_instructions(function))
    meanings = tuple(meaning_of(name, owner.buffers) for name in names[1:])
    return Behaviour(function, tuple(names[1:]), meanings, returns, reads_constants)


def _refuse_no_unit(owner: type[Block], name: str, text: str) -> None:
    """Raise TypeError where a block of the user's own has a unit that is none; tests see to those of the library."""
    if owner.__module__.startswith("proofmass.blocks."):
        return
    texts = {n: p.default for n, p in owner.parameters.items() if p.kind is str}
    try:
        unit(fill(text, texts))
    except UnitError as error:
        raise TypeError(f"{owner.__name__}.{name}: {error}" + (f"; {error.hint}" if error.hint else "")) from None


def _names_a_unit(name: str) -> bool:
    return name == "unit" or name.endswith("_unit")
