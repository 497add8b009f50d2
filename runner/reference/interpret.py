"""The reference engine: the plan run in plain Python, tick by tick. Debuggers can stop in it."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, assert_never

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.arithmetic.fixed_point import FixedValue, counting_overflows, stored
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, shape_of
from proofmass.graphs.checks.schedule import AlgebraicLoop, Beat, ConstantsOf, OutputStep, outputs_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.continuous.algebraic import NoSolutionError, solve_in_place
from proofmass.runner.plan.bindings import (
    Binding,
    BufferBinding,
    Default,
    Deviate,
    Out,
    Parameters,
    StateBinding,
    Tick,
    Time,
    WireBinding,
)
from proofmass.runner.plan.constants import constants_of, in_python
from proofmass.runner.plan.memory import Memory, Rows, start
from proofmass.runner.plan.planned import Filled, Plan
from proofmass.runner.reference.advance import Advance, IntegrationError, Moment, PlainAdvance, TooOftenError


class TickError(ArithmeticError):
    """A block that failed, or a number that is not finite: `at` names function, wire or state."""

    def __init__(self, at: str, tick: int, value: Any) -> None:
        super().__init__(f"{at} in tick {tick}: {value}")
        self.at, self.tick, self.value = at, tick, value


class OutOfBoundsError(ArithmeticError):
    """A driven parameter that has left the bounds that its block declares."""

    def __init__(self, value: float) -> None:
        super().__init__(f"{value:.9g}")
        self.value = value


class Outputs:
    """The outputs of a tick in their order: all that can be computed before continuous groups have solvers."""

    _solve_loop = staticmethod(solve_in_place)  # on the wires; whether there is a solution

    def __init__(self, plan: Filled, seed: int, run: int = 0, memory: Memory | None = None) -> None:
        self.filled, self.seed, self.run = plan, seed, run
        self._memory = memory or start(plan)
        self._constants = dict(plan.constants)
        self._period = plan.period  # a quotient of exact numbers, as slow as a small block
        self._owner = ""  # the block whose function is bound to its arguments
        self._at = ""  # the function under way, for messages
        self._overflowed: set[str] = set()  # in this tick
        steps = {step: self._step(step) for step in plan.schedule.order}
        nodes = {node: steps[node] for node in outputs_of(steps)}
        steps |= {tear: step for loop in plan.schedule.loops for tear, step in self._solved(loop, nodes)}
        self._outputs = [(step, self._beat(step), compute) for step, compute in steps.items()]
        self._names = {
            step: f"{step.block}.constants" if isinstance(step, ConstantsOf) else ".".join(step) for step in steps
        }

    def first_tick(self) -> tuple[dict[str, Any], dict[Endpoint, Any]]:
        """Constants and wires of tick 0; of a block that fails there, what they were before."""
        with suppress(ArithmeticError, ValueError):
            self._compute(0)
        return self._constants, self._memory.wires

    def _beat(self, step: OutputStep) -> Beat:
        if isinstance(step, ConstantsOf):
            return self.filled.schedule.beat(step.block)
        return self.filled.beat(step)

    def _compute(self, tick: int) -> None:
        """Outputs due in a tick, in their order."""
        wires, names = self._memory.wires, self._names
        for step, (stride, phase), compute in self._outputs:
            if tick % stride != phase:
                continue
            self._at = names[step]
            value = compute(tick)
            if isinstance(step, ConstantsOf):
                self._constants[step.block] = value
                continue
            if not (type(value) is float and math.isfinite(value)) and not self._finite(value):  # most are numbers
                raise TickError(self._at, tick, value)
            wires[step] = value

    def _solved(
        self, loop: AlgebraicLoop, steps: Mapping[Endpoint, Callable[[int], Any]]
    ) -> Iterator[tuple[Endpoint, Callable[[int], Any]]]:
        """Yield the steps of the tears of a loop: all are known once the first is."""
        wires = self._memory.wires

        def solve(tick: int) -> float:
            if not self._solve_loop(loop.tears, loop.others, wires, lambda node: steps[node](tick)):
                raise NoSolutionError(self._at)
            return wires[loop.tears[0]]  # type: ignore[no-any-return]

        yield loop.tears[0], solve
        for tear in loop.tears[1:]:
            yield tear, lambda tick, tear=tear: wires[tear]  # type: ignore[misc]

    def _step(self, step: OutputStep) -> Callable[[int], Any]:
        return self._driven(step.block) if isinstance(step, ConstantsOf) else self._output(*step)

    def _output(self, name: str, port: str) -> Callable[[int], Any]:
        shape = shape_of(self.filled.blocks[name], type(self.filled.blocks[name]).outputs[port])
        compute = self._bound(name, port)

        def fill(tick: int) -> Any:
            compute(tick)
            return self._memory.wires[name, port]

        return self._held(name, port, fill if shape else compute)

    def _held(self, name: str, port: str, compute: Callable[[int], Any]) -> Callable[[int], Any]:
        """An output, checked where a converter makes mantissas: no trace knows their range."""
        block = self.filled.blocks[name]
        if type(block).outputs[port].dtype is not FixedValue or type(block).has_formats():
            return compute
        format = format_of(block, port)

        def checked(tick: int) -> Any:
            value = compute(tick)
            for mantissa in value if isinstance(value, list) else [value]:
                stored(FixedValue(mantissa, format.fraction), format)
            return value

        return checked

    def _driven(self, name: str) -> Callable[[int], Any]:
        """Constants made anew from the wires that drive parameters."""
        block, drivers = self.filled.blocks[name], self.filled.schedule.drivers
        parameters = type(block).parameters_class()
        period = self.filled.block_period(name)
        bounded = [
            (p, declared, drivers[name, p])
            for p, declared in type(block).parameters.items()
            if (name, p) in drivers and declared.bounds()
        ]

        def compute(tick: int) -> Any:
            for parameter, declared, driver in bounded:
                if not declared.inside(self._memory.wires[driver]):
                    raise TickError(f"{name}.{parameter}", tick, OutOfBoundsError(self._memory.wires[driver]))
            values = (
                self._memory.wires[drivers[name, p]] if (name, p) in drivers else getattr(block, p)
                for p in parameters._fields  # type: ignore[attr-defined]
            )
            return constants_of(block, parameters(*values), period)

        return compute

    def _bound(self, name: str, function: str) -> Callable[[int], Any]:
        """A function of a block with every argument looked up in the tick."""
        self._owner = name
        block = self.filled.blocks[name]
        behaviour = type(block).output_functions.get(function) or type(block).functions[function]
        bindings = self.filled.bindings(name, function)
        call = self._counted(name, function) if name in self.filled.digital else self._callable(block, behaviour)
        constants = self._constants
        lookups = [place for place in map(self._place, bindings) if place is not None]
        if len(lookups) == len(bindings):  # nothing follows from the tick: faster
            return _of_places(call, constants, name, lookups)
        getters = [self._getter(binding) for binding in bindings]
        return lambda tick: call(constants[name], *[get(tick) for get in getters])

    def _place(self, binding: Binding) -> tuple[Mapping[Any, Any], Any] | None:
        """Return the table that holds a state or a wire, and the key in it."""
        match binding:
            case StateBinding(name):
                return self._memory.states, name
            case Out(node) | WireBinding(node):
                return self._memory.wires, node
            case _:
                return None

    def _counted(self, name: str, function: str) -> Callable[..., Any]:
        """A function of a digital block, on raw values; it notes when a cast saturates or wraps."""
        reference = self.filled.digital[name].steps[function].reference

        def call(*arguments: Any) -> Any:
            with counting_overflows() as overflows:
                value = reference(*arguments)
            if overflows.total:
                self._overflowed.add(name)
            return value

        return call

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        """Return what is called for a function of a block."""
        return in_python(block, behaviour)

    def _finite(self, value: Any) -> bool:
        """Return whether a value, or each entry of a vector or state, is finite."""
        if isinstance(value, list | tuple):
            return all(map(math.isfinite, value))
        return math.isfinite(value)

    def _getter(self, binding: Binding) -> Callable[[int], Any]:
        """Return the function that looks up an argument in a tick."""
        memory, period = self._memory, self._period
        match binding:
            case StateBinding(name):
                return lambda tick: memory.states[name]
            case Parameters(name):
                block = self.filled.blocks[name]
                return lambda tick: block
            case Out(node) | WireBinding(node):
                return lambda tick: memory.wires[node]
            case Time():
                return lambda tick: tick * period
            case Tick(divisor, phase):
                return lambda tick: (tick - phase) // divisor
            case Deviate(name, divisor, phase):
                seed, run, stream = self.seed, self.run, self.filled.stream(name)
                return lambda tick: normal_deviate(seed, run, stream, (tick - phase) // divisor)
            case BufferBinding(node):
                buffer = memory.buffers[node]
                return lambda tick: buffer
            case Default(_, value):
                return lambda tick: value
            case _:
                assert_never(binding)


def _of_places(
    call: Callable[..., Any], constants: Mapping[str, Any], name: str, places: Sequence[tuple[Mapping[Any, Any], Any]]
) -> Callable[[int], Any]:
    """Return a call with what is in some places; a loop over up to three would take as long as a small block."""
    match places:
        case [(a, i)]:
            return lambda tick: call(constants[name], a[i])
        case [(a, i), (b, j)]:
            return lambda tick: call(constants[name], a[i], b[j])
        case [(a, i), (b, j), (c, k)]:
            return lambda tick: call(constants[name], a[i], b[j], c[k])
        case _:
            return lambda tick: call(constants[name], *[values[key] for values, key in places])


class Interpreter(Outputs):
    """One tick: outputs in topological order, updates of discrete blocks, continuous groups to the next tick."""

    name = "python"

    def __init__(self, plan: Plan, seed: int, run: int = 0, memory: Memory | None = None) -> None:
        super().__init__(plan, seed, run, memory)
        self.plan = plan
        self._advances: list[Advance] = [
            PlainAdvance(plan, solver, self._memory.buffers.get(solver.largest) or [0.0] * len(solver.group.states))
            for solver in plan.solvers
        ]
        self._updates = [
            (name, plan.schedule.beat(name), self._bound(name, "update"))
            for name, block in plan.blocks.items()
            if "update" in type(block).functions
        ]
        self._folds = [
            (name, self._bound(name, "fold")) for name, block in plan.blocks.items() if "fold" in type(block).functions
        ]
        self._sources = [(node, self._source(*node), plan.bindings(*node)) for node in plan.ahead]

    def memory(self) -> Memory:
        """Return the memory itself, which moves on with the run."""
        return self._memory

    def snapshot(self) -> Callable[[], Memory]:
        """Return a function that gives the memory of this moment."""
        kept = self._memory.copy()
        return lambda: kept

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `TickError`."""
        counts = [0] * len(rows)
        for tick in range(self._memory.tick, last):
            try:
                self._compute(tick)
                for i, probe in enumerate(self.plan.probes):
                    if tick % probe.stride == probe.phase:
                        rows[i][counts[i]] = self._memory.wires[probe.node]
                        counts[i] += 1
                self._move(tick)
            except TickError:
                raise
            except Exception as error:
                raise TickError(self._at, tick, error) from error
        return True

    def _move(self, tick: int) -> None:
        """Updates due in a tick, then the continuous groups to the next."""
        states = self._memory.states
        for name, (divisor, phase), step in self._updates:
            if tick % divisor == phase:
                self._at = f"{name}.update"
                state = step(tick)
                if state is not None:
                    states[name] = state
        following = self._ahead(tick) if self._advances else {}
        for advance in self._advances:
            moment = Moment(self._constants, states, self._memory.wires, following, tick * self._period)
            try:
                moved = advance(moment)
            except (IntegrationError, NoSolutionError) as error:
                lost = "" if isinstance(error, TooOftenError) else advance.lost(moment)
                raise TickError(lost or error.at, tick, math.nan if lost else error) from error
            except Exception:
                self._at = advance.stages.at
                raise
            broken = next((name for name in moved if not self._finite(moved[name])), "")
            if broken:
                lost = advance.lost(moment)
                raise TickError(lost or f"{broken}.state", tick, math.nan if lost else moved[broken])
            states.update(moved)
        for name, fold in self._folds:
            self._at = f"{name}.fold"
            states[name] = fold(tick)
        for name in self._overflowed & self._memory.overflows.keys():
            self._memory.overflows[name] += 1
        self._overflowed.clear()
        self._memory.tick = tick + 1

    def _ahead(self, tick: int) -> dict[Endpoint, float]:
        """Values that sources have in the next tick."""
        following = dict[Endpoint, float]()
        for node, call, given in self._sources:
            self._at = ".".join(node)
            values = [self._following(binding, tick + 1, following) for binding in given]
            following[node] = call(self._constants[node[0]], *values)
        return following

    def _source(self, name: str, port: str) -> Callable[..., Any]:
        block = self.plan.blocks[name]
        return in_python(block, type(block).output_functions[port])

    def _following(self, binding: Binding, tick: int, following: Mapping[Endpoint, float]) -> float:
        """Return an argument of a source in the next tick."""
        match binding:
            case Time():
                return tick * self._period
            case WireBinding(node):
                return following[node]
            case Default(_, value):
                return value
            case StateBinding() | Parameters() | Out() | Tick() | Deviate() | BufferBinding():
                raise ValueError(f"{binding} does not follow from the time alone")
            case _:
                assert_never(binding)
