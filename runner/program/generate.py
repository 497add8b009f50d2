"""The plan as Python source of one fused loop: readable, and compiled as it stands.

Numbers that a run may change (parameters, seed, state) are arguments of the loop, never written into the source;
what is fixed by the graph (wiring, rate ratios, sizes) is.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.instance import shape_of
from proofmass.graphs.checks.schedule import ConstantsOf, Node, outputs_of
from proofmass.graphs.model.rates import write_rate
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.keys import (
    BasePeriod,
    ConstantOf,
    Given,
    Moving,
    OverflowsOf,
    ParameterOf,
    PeriodOf,
    StateField,
    VectorOf,
    WireOf,
    made_up,
    variable,
    word,
)
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.c_function import CFunction
from proofmass.runner.program.digital_code import DigitalCode
from proofmass.runner.program.group_code import GroupCode
from proofmass.runner.program.loop_code import LoopCode
from proofmass.runner.program.pieces import FLOATS, INTEGERS, Pieces, Slots, entries, fields
from proofmass.runner.program.watched import watched


@dataclass(frozen=True)
class Generated:
    """The loop's source, the functions it calls by name, and where its numbers stand."""

    source: str
    names: Mapping[str, Callable[..., Any] | type | CFunction]
    constants: Slots[Given]
    constant_values: Mapping[Given, Any]
    memory: Slots[Moving]
    vectors: tuple[VectorOf, ...]  # buffers and wires with a shape, in the order of the arguments
    vector_kinds: tuple[type, ...]
    scratch: int  # floats that the loop works on, not kept from call to call
    functions: tuple[str, ...]  # that the source defines before the loop
    inlined: frozenset[str]  # those of them that are worth it wherever they are called
    steps: tuple[str, ...]  # source of those among the names that are integer code
    lanes: int  # runs that the loop moves side by side; 0 for a loop of one run

    @property
    def listing(self) -> str:
        """The loop and the integer code that it calls, for readers."""
        return "\n\n".join([self.source, *self.steps])


def generate(plan: Plan) -> Generated:
    """Source and layout of the compiled loop of a plan."""
    return LoopGenerator(plan).generated()


class LoopGenerator(Pieces):
    """Writes the loop; what it is made of is written by `GroupCode`, `LoopCode` and `DigitalCode`."""

    def __init__(self, plan: Plan, lanes: int = 0) -> None:
        super().__init__(plan, lanes)
        self.groups = [GroupCode(self, solver) for solver in plan.solvers]
        self.digital = DigitalCode(self)
        self.loops = [LoopCode(self, loop, f"loop_{number}") for number, loop in enumerate(plan.schedule.loops)]
        self.parts: list[LoopCode | GroupCode] = [*self.loops, *self.groups]
        self.vectors: dict[VectorOf, tuple[type, tuple[int, ...]]] = {}
        for solver in plan.solvers:
            if solver.largest in plan.buffers:
                self.vectors[solver.largest] = (float, (len(solver.group.states),))
        for name, block in plan.blocks.items():
            for buffer, declared in type(block).buffers.items():
                self.vectors[name, buffer] = (held_as(declared.dtype), (len(plan.buffers[name, buffer]),))
            for port, output in type(block).outputs.items():
                if output.shape:
                    self.vectors[name, port] = (held_as(output.dtype), shape_of(block, output))

    def generated(self) -> Generated:
        """The whole of it."""
        before = list(self._unpacked())
        tick = [*self._outputs(), *self._probes(), *self._updates(), *self._groups()]
        flags = {"not_finite": self.memory.at(FLOATS, self.memory.counts[FLOATS])}
        if self.refuses:
            flags["refused"] = self.memory.at(INTEGERS, self.memory.counts[INTEGERS])
        after = [*self._packed(), *(f"{place} = {flag}" for flag, place in flags.items())]
        body = self._arranged(before, flags, tick, after)
        functions = [line for part in self.parts for line in part.functions()]
        own = [line[4 : line.index("(")] for line in functions if line.startswith("def ")]
        lines = [*self._head(), *functions, *self._signature()]
        lines += [f"    {line}" if line else "" for line in [*self._views(), *body]]
        return Generated(
            "\n".join(lines) + "\n",
            self.names,
            self.constants,
            self.values,
            self.memory,
            tuple(self.vectors),
            tuple(kind for kind, _ in self.vectors.values()),
            self._scratch(),
            tuple(own),
            frozenset(name for group in self.groups for name in group.inlined()),
            tuple(self.digital.steps[name] for name in sorted(self.digital.steps)),
            self.lanes,
        )

    def _arranged(self, before: list[str], flags: Mapping[str, str], tick: list[str], after: list[str]) -> list[str]:
        """The body of the loop's function: what is read first, the ticks, what is written back; `flags` by place."""
        zeros = [f"{flag} = {'0.0' if flag == 'not_finite' else '0'}" for flag in flags]
        rows = [f"row_{i} = 0" for i, probe in enumerate(self.plan.probes) if probe.stride > 1]
        ticks = ["time = tick * period", *tick]
        return [*before, "", *rows, *zeros, "for tick in range(first, last):", *(f"    {x}" for x in ticks), *after]

    def _scratch(self) -> int:
        return sum(sum(part.scratch.values()) for part in self.parts)

    def _scratch_of(self, place: int, length: int) -> str:
        return f"scratch[{place}:{place + length}]"

    # -- the parts of the source, in their order -------------------------------------------------------------------

    def _head(self) -> Iterator[str]:
        plan = self.plan
        base = write_rate(plan.schedule.base_rate)
        yield f'"""Generated loop of {len(plan.blocks)} blocks at {base}; block__port is what a wire holds."""'
        yield ""
        yield "# The functions that it calls, each compiled from the file of its block:"
        for name, value in sorted(self.names.items()):
            yield f"# {name}: {'integer code' if name in self.digital.steps else _origin(value)}"
        yield ""
        yield ""

    def _signature(self) -> Iterator[str]:
        plan = self.plan
        arguments = [
            "first",
            "last",
            "seed",
            "runs" if self.lanes else "run",
            FLOATS,
            INTEGERS,
            "state_numbers",
            "state_integers",
            "scratch",
        ]
        arguments += [variable(node) for node in self.vectors]
        arguments += [f"probe_{i}" for i in range(len(plan.probes))]
        yield "def loop("
        yield from (f"    {argument}," for argument in arguments)
        yield "):"

    def _views(self) -> Iterator[str]:
        """Arrays over the memory that the loop is given; their sizes are fixed by the graph."""
        for slots in (self.constants, self.memory):
            for array, count in slots.counts.items():
                yield f"{slots.prefix}{array} = carray({slots.prefix}{array}, ({count + 1},))"
        yield f"scratch = carray(scratch, ({self._scratch() + 1},))"
        for node, (_, shape) in self.vectors.items():
            yield f"{variable(node)} = carray({variable(node)}, {shape})"
        for i, probe in enumerate(self.plan.probes):
            rows = "last - first" if probe.stride == 1 else f"(last - first) // {probe.stride} + 1"
            yield f"probe_{i} = carray(probe_{i}, ({', '.join([rows, *map(str, probe.shape)])},))"

    def _unpacked(self) -> Iterator[str]:
        plan = self.plan
        yield f"period = {self.constant(BasePeriod(), float, plan.period)}"
        for name in plan.blocks:
            yield from self._constants_of(name)
        place = 0
        for part in self.parts:
            for key, length in part.scratch.items():
                yield f"{part.name}_{key} = {self._scratch_of(place, length)}"
                place += length
        for group in self.groups:
            yield from group.before()
        for name, block in plan.blocks.items():
            state = type(block).state_class()
            if state is not None:
                held = [self.memory.add(StateField(name, f), held_as(k)) for f, k in fields(state)]
                yield f"{made_up(word(name), 'x')} = {self.named(block, 'State', state)}({', '.join(held)})"
            for port, output in type(block).outputs.items():
                if not output.shape:
                    yield f"{variable((name, port))} = {self.memory.add(WireOf(name, port), held_as(output.dtype))}"
        yield from self.digital.before()

    def _constants_of(self, name: str) -> Iterator[str]:
        """Constants of a block as they are given, or the parameters from which each tick makes them."""
        block, values = self.plan.blocks[name], self.plan.constants[name]
        if self.plan.is_driven(name):
            yield from self._parameters_of(name)
            return
        made = type(values)
        given = [self.constant(ConstantOf(name, f), k, v) for (f, k), v in zip(fields(made), values, strict=True)]
        yield f"{made_up(word(name), 'c')} = " + (
            f"{self.named(block, 'Constants', made)}({', '.join(given)})" if given else "0"
        )

    def _parameters_of(self, name: str) -> Iterator[str]:
        plan, block = self.plan, self.plan.blocks[name]
        for p, kind in fields(type(block).parameters_class()):
            if (name, p) not in plan.schedule.drivers:
                value = self.constant(ParameterOf(name, p), kind, getattr(block, p))
                yield f"{self.parameter(name, p)} = {value}"
        period = self.constant(PeriodOf(name), float, plan.block_period(name))
        yield f"{made_up(word(name), 'period')} = {period}"

    def _outputs(self) -> Iterator[str]:
        plan = self.plan
        yield from self.digital.begin_tick()
        drawn: set[str] = set()
        looked_at = watched(plan)
        yield from when_due(self._in_order(drawn, looked_at))
        for name, block in plan.blocks.items():
            update = type(block).functions.get("update")
            if update is not None and "normal" in update.arguments and name not in drawn:
                yield self.deviate(name)
        due = (node for node in outputs_of(plan.schedule.order) if node in looked_at and plan.stride(node) == 1)
        in_every_tick = [entry for node in due for entry in self._entries(node)]
        if in_every_tick:
            yield "# NaN from here on when one of these is not finite:"
            yield f"watched = {in_every_tick[0]}"
            yield from (f"watched += {entry}" for entry in in_every_tick[1:])
            yield "not_finite += watched - watched"

    def _in_order(self, drawn: set[str], looked_at: frozenset[Node]) -> Iterator[tuple[int, str]]:
        """Lines of the outputs in their order, each with the ticks from one time to the next; notes what has drawn."""
        plan = self.plan
        tears = {tear for loop in plan.schedule.loops for tear in loop.tears}
        for step in plan.schedule.order:
            if isinstance(step, ConstantsOf):
                divisor = plan.schedule.divisors[step.block]
                yield from ((divisor, line) for line in self.within_bounds(step.block))
                yield from ((divisor, line) for line in self.driven(step.block))
                continue
            name, port = step
            block, stride = plan.blocks[name], plan.stride(step)
            if "normal" in type(block).output_functions[port].arguments and name not in drawn:
                drawn.add(name)
                yield stride, self.deviate(name)
            output = type(block).outputs[port]
            target = "" if output.shape else variable((name, port))
            solved = [line for loop in self.loops for line in loop.at((name, port))]
            lines = solved if (name, port) in tears else self._kept(name, port, target)
            yield from ((stride, line) for line in lines)
            if output.dtype is FixedValue and not type(block).digital():
                yield from ((stride, line) for line in self.digital.hold((name, port)))
            if (name, port) in looked_at and stride > 1:
                yield from ((stride, f"not_finite += {entry} - {entry}") for entry in self._entries((name, port)))

    def _entries(self, node: Node) -> list[str]:
        block = self.plan.blocks[node[0]]
        return entries(node, shape_of(block, type(block).outputs[node[1]]))

    def _probes(self) -> Iterator[str]:
        for i, probe in enumerate(self.plan.probes):
            wire = variable(probe.node)
            row = "tick - first" if probe.stride == 1 else f"row_{i}"
            indent = ""
            if probe.stride > 1:
                yield f"if tick % {probe.stride} == 0:"
                indent = "    "
            if probe.shape:
                yield f"{indent}for entry in range({probe.shape[0]}):"
                yield f"{indent}    probe_{i}[{row}, entry] = {wire}[entry]"
            else:
                yield f"{indent}probe_{i}[{row}] = {wire}"
            if probe.stride > 1:
                yield f"{indent}row_{i} += 1"

    def _updates(self) -> Iterator[str]:
        yield from when_due(self._updated())
        yield from self.digital.end_tick()

    def _updated(self) -> Iterator[tuple[int, str]]:
        """Lines of the updates, each with the ticks from one time to the next."""
        for name, block in self.plan.blocks.items():
            if "update" in type(block).functions:
                target = "" if type(block).state_class() is None else made_up(word(name), "x")
                divisor = self.plan.schedule.divisors[name]
                yield from ((divisor, line) for line in self._kept(name, "update", target))

    def _kept(self, name: str, function: str, target: str) -> Iterator[str]:
        """Lines that call a function and keep what it returns in `target`, where there is one."""
        if name in self.plan.digital:
            return self.digital.call(name, function, target)
        return self.kept(name, function, target, self.call(name, function, function))

    def _groups(self) -> Iterator[str]:
        """Continuous groups to the next tick; sources that they ramp towards are computed ahead."""
        if self.plan.ahead:
            yield "time_next = (tick + 1) * period"
        for name, port in self.plan.ahead:
            behaviour = type(self.plan.blocks[name]).output_functions[port]
            arguments = (self._next(name, port, argument) for argument in behaviour.arguments)
            call = self.called(name, port, behaviour, [made_up(word(name), "c"), *arguments])
            yield f"{made_up(variable((name, port)), 'next')} = {self.number(call)}"
        for group in self.groups:
            yield from group.move()

    def _next(self, name: str, port: str, argument: str) -> str:
        now = self.argument(name, port, argument)
        if (name, argument) in self.plan.schedule.drivers:
            return made_up(now, "next")
        return "time_next" if argument == "time" else now

    def _packed(self) -> Iterator[str]:
        for key in self.memory.kinds:
            match key:
                case OverflowsOf(block):
                    yield f"{self.memory.write(key)} = {made_up(word(block), 'overflows')}"
                case StateField(block, field):
                    yield f"{self.memory.write(key)} = {made_up(word(block), 'x')}.{field}"
                case WireOf(block, port):
                    yield f"{self.memory.write(key)} = {variable((block, port))}"


def when_due(lines: Iterable[tuple[int, str]]) -> Iterator[str]:
    """Lines of which each stands with the ticks from one time to the next, under the conditions that they are due.

    >>> list(when_due([(1, "a = 1"), (4, "b = a"), (4, "c = b")]))
    ['a = 1', 'if tick % 4 == 0:', '    b = a', '    c = b']
    """
    for stride, together in groupby(lines, key=itemgetter(0)):
        if stride > 1:
            yield f"if tick % {stride} == 0:"
        yield from ("    " * (stride > 1) + line for _, line in together)


def _origin(value: Any) -> str:
    return f"{value.symbol} in C" if isinstance(value, CFunction) else f"{value.__module__}.{value.__qualname__}"
