"""The plan as Python source of one fused loop: readable, and compiled as it stands.

Numbers that a run may change (parameters, seed, state) are arguments of the loop, never written into the source;
what is fixed by the graph (wiring, rate ratios, sizes) is.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from proofmass.blocks.counter_random import normal_deviate
from proofmass.graphs.rates import write_rate
from proofmass.graphs.schedule import Node
from proofmass.runner.plan import Plan

FLOATS, INTEGERS = "numbers", "integers"


@dataclass
class Slots:
    """Numbers that travel between a run and the loop in two arrays, one of floats and one of integers."""

    prefix: str
    kinds: dict[Any, tuple[type, int]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=lambda: {FLOATS: 0, INTEGERS: 0})

    def add(self, key: Any, kind: type) -> str:
        """A place for one number; returns the expression that reads it."""
        self.kinds[key] = (kind, self.counts[_array(kind)])
        self.counts[_array(kind)] += 1
        return self.read(key)

    def read(self, key: Any) -> str:
        """The expression that reads a number."""
        kind, _ = self.kinds[key]
        return f"{self.write(key)} != 0" if kind is bool else self.write(key)

    def write(self, key: Any) -> str:
        """The place to which a number is written back."""
        kind, index = self.kinds[key]
        return f"{self.prefix}{_array(kind)}[{index}]"


@dataclass(frozen=True)
class Generated:
    """The loop's source, the functions it calls by name, and where its numbers stand."""

    source: str
    names: Mapping[str, Callable[..., Any] | type]
    constants: Slots
    constant_values: Mapping[Any, Any]
    memory: Slots
    vectors: tuple[Node, ...]  # buffers and wires with a shape, in the order of the arguments
    vector_kinds: tuple[type, ...]


def generate(plan: Plan) -> Generated:
    """Source and layout of the compiled loop of a plan."""
    return _Generator(plan).generated()


class _Generator:
    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.names: dict[str, Any] = {}
        self.constants, self.memory = Slots(""), Slots("state_")
        self.values: dict[Any, Any] = {}
        self.vectors: dict[Node, tuple[type, tuple[int, ...]]] = {}
        for name, block in plan.blocks.items():
            for buffer, declared in block.buffers.items():
                self.vectors[name, buffer] = (declared.dtype, (len(plan.buffers[name, buffer]),))
            for port, output in block.outputs.items():
                if output.shape:
                    self.vectors[name, port] = (output.dtype, block.shape_of(output))

    def generated(self) -> Generated:
        before = [*self._unpacked(), ""]
        loop = [*self._outputs(), *self._probes(), *self._updates(), *self._groups()]
        after = [*self._packed()]
        rows = [f"row_{i} = 0" for i, probe in enumerate(self.plan.probes) if probe.stride > 1]
        body = [*self._views(), *before, *rows, "not_finite = 0.0", "for tick in range(first, last):"]
        body += ["    time = tick * period", *(f"    {line}" for line in loop), *after]
        body += [f"state_{FLOATS}[{self.memory.counts[FLOATS]}] = not_finite"]
        source = "\n".join([*self._head(), *(f"    {line}" if line else "" for line in body)]) + "\n"
        return Generated(
            source,
            self.names,
            self.constants,
            self.values,
            self.memory,
            tuple(self.vectors),
            tuple(kind for kind, _ in self.vectors.values()),
        )

    # -- the parts of the source, in their order -------------------------------------------------------------------

    def _head(self) -> Iterator[str]:
        plan = self.plan
        base = write_rate(plan.schedule.base_rate)
        yield f'"""Generated loop of {len(plan.blocks)} blocks at {base}; block__port is what a wire holds."""'
        yield ""
        yield "# The functions that it calls, each compiled from the file of its block:"
        for name, value in sorted(self.names.items()):
            yield f"# {name}: {value.__module__}.{value.__qualname__}"
        yield ""
        yield ""
        arguments = ["first", "last", "seed", "run", FLOATS, INTEGERS, "state_numbers", "state_integers"]
        arguments += [_variable(node) for node in self.vectors]
        arguments += [f"probe_{i}" for i in range(len(plan.probes))]
        yield "def loop("
        yield from (f"    {argument}," for argument in arguments)
        yield "):"

    def _views(self) -> Iterator[str]:
        """Arrays over the memory that the loop is given; their sizes are fixed by the graph."""
        for slots in (self.constants, self.memory):
            for array, count in slots.counts.items():
                yield f"{slots.prefix}{array} = carray({slots.prefix}{array}, ({count + 1},))"
        for node, (_, shape) in self.vectors.items():
            yield f"{_variable(node)} = carray({_variable(node)}, {shape})"
        for i, probe in enumerate(self.plan.probes):
            rows = "last - first" if probe.stride == 1 else f"(last - first) // {probe.stride} + 1"
            yield f"probe_{i} = carray(probe_{i}, ({', '.join([rows, *map(str, probe.shape)])},))"

    def _unpacked(self) -> Iterator[str]:
        plan = self.plan
        yield f"period = {self._constant('period', float, plan.period)}"
        for name, block in plan.blocks.items():
            made = block.constants_class()
            if plan.constants[name] is not None:
                values = plan.constants[name]
                fields = [self._constant((name, f), k, v) for (f, k), v in zip(_fields(made), values, strict=True)]
                if fields:
                    yield f"{_word(name)}__c = {self._named(block, 'Constants', made)}({', '.join(fields)})"
                else:
                    yield f"{_word(name)}__c = 0"
            else:
                for p, kind in _fields(block.parameters_class()):
                    if (name, p) not in plan.schedule.drivers:
                        yield f"_{_word(name)}__{p} = {self._constant((name, 'parameter', p), kind, getattr(block, p))}"
                yield f"{_word(name)}__period = {self._constant((name, 'period'), float, plan.block_period(name))}"
        for number, group in enumerate(plan.groups):
            for i, row in enumerate(zip(group.transition, group.entry, strict=True)):
                for j, value in enumerate((*row[0], *row[1])):
                    yield f"group_{number}_{i}_{j} = {self._constant(('group', number, i, j), float, value)}"
        for name, block in plan.blocks.items():
            state = block.state_class()
            if state is not None:
                fields = [self.memory.add((name, "x", f), k) for f, k in _fields(state)]
                yield f"{_word(name)}__x = {self._named(block, 'State', state)}({', '.join(fields)})"
            for port, output in block.outputs.items():
                if not output.shape:
                    yield f"{_word(name)}__{port} = {self.memory.add((name, port), output.dtype)}"

    def _outputs(self) -> Iterator[str]:
        plan = self.plan
        drawn: set[str] = set()
        watched: list[str] = []  # of every tick
        persistent = {node for group in plan.groups for node in group.inputs}  # what enters a group stays in its state
        due = 1
        for name, port in plan.schedule.order:
            block, divisor = plan.blocks[name], plan.schedule.divisors[name]
            stride = plan.stride((name, port)) if port else divisor
            behaviours = [block.output_functions[port]] if port else []
            if stride != due and stride > 1:
                yield f"if tick % {stride} == 0:"
            due = stride
            indent = "    " if stride > 1 else ""
            if any("normal" in b.arguments for b in behaviours) and name not in drawn:
                drawn.add(name)
                yield indent + self._deviate(name)
            if not port:
                yield indent + self._driven(name)
                continue
            call = self._call(name, port, port)
            output = block.outputs[port]
            yield indent + (call if output.shape else f"{_word(name)}__{port} = {call}")
            if output.dtype is float and (name, port) not in persistent:
                entries = _entries((name, port), block.shape_of(output))
                if stride == 1:
                    watched += entries
                else:
                    yield from (f"{indent}not_finite += {entry} - {entry}" for entry in entries)
        for name, block in plan.blocks.items():
            update = block.functions.get("update")
            if update is not None and "normal" in update.arguments and name not in drawn:
                yield self._deviate(name)
        if watched:
            yield "# NaN from here on when one of these is not finite:"
            yield f"watched = {watched[0]}"
            yield from (f"watched += {entry}" for entry in watched[1:])
            yield "not_finite += watched - watched"

    def _probes(self) -> Iterator[str]:
        for i, probe in enumerate(self.plan.probes):
            wire = _variable(probe.node)
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
        for name, block in self.plan.blocks.items():
            if "update" not in block.functions:
                continue
            divisor = self.plan.schedule.divisors[name]
            call = self._call(name, "update", "update")
            line = call if block.state_class() is None else f"{_word(name)}__x = {call}"
            if divisor > 1:
                yield f"if tick % {divisor} == 0:"
                line = "    " + line
            yield line

    def _groups(self) -> Iterator[str]:
        """x[n+1] = transition x[n] + entry u[n], in the order of the reference engine."""
        for number, group in enumerate(self.plan.groups):
            terms = [f"{_word(block)}__x.{name}" for block, name in group.states] + [
                _variable(node) for node in group.inputs
            ]
            moved = {}
            for i, state in enumerate(group.states):
                factors = (f"group_{number}_{i}_{j} * {term}" for j, term in enumerate(terms))
                moved[state] = f"_{_word(state[0])}__{state[1]}"
                yield f"{moved[state]} = {' + '.join(factors)}"
            for name in group.blocks:
                block = self.plan.blocks[name]
                state_class: Any = block.state_class()
                fields = ", ".join(moved[name, f] for f in state_class._fields)
                yield f"{_word(name)}__x = {self._named(block, 'State', state_class)}({fields})"

    def _packed(self) -> Iterator[str]:
        for key in self.memory.kinds:
            if len(key) == 3:
                yield f"{self.memory.write(key)} = {_word(key[0])}__x.{key[2]}"
            else:
                yield f"{self.memory.write(key)} = {_variable(key)}"

    # -- pieces ----------------------------------------------------------------------------------------------------

    def _call(self, name: str, function: str, port: str) -> str:
        block = self.plan.blocks[name]
        behaviour = block.output_functions.get(function) or block.functions[function]
        arguments = [f"{_word(name)}__c", *(self._argument(name, port, a) for a in behaviour.arguments)]
        return f"{self._named(block, function, behaviour.function)}({', '.join(arguments)})"

    def _argument(self, name: str, port: str, argument: str) -> str:
        plan = self.plan
        block, divisor = plan.blocks[name], plan.schedule.divisors[name]
        fixed = {
            "x": f"{_word(name)}__x",
            "out": f"{_word(name)}__{port}",
            "time": "time",
            "normal": f"{_word(name)}__normal",
        }
        if argument in fixed:
            return fixed[argument]
        if argument == "tick":
            return "tick" if divisor == 1 else f"tick // {divisor}"
        if argument in block.buffers:
            return f"{_word(name)}__{argument}"
        driver = plan.schedule.drivers.get((name, argument))
        declared = block.inputs[argument]
        if driver is None:
            return repr(declared.dtype(declared.default))  # type: ignore[arg-type]
        return _variable(driver)

    def _driven(self, name: str) -> str:
        block, drivers = self.plan.blocks[name], self.plan.schedule.drivers
        made = block.parameters_class()
        values = [
            _variable(drivers[name, p]) if (name, p) in drivers else f"_{_word(name)}__{p}" for p, _ in _fields(made)
        ]
        parameters = f"{self._named(block, 'Parameters', made)}({', '.join(values)})"
        if "constants" not in block.functions:
            return f"{_word(name)}__c = {parameters}"
        function = self._named(block, "constants", block.functions["constants"].function)
        return f"{_word(name)}__c = {function}({parameters}, {_word(name)}__period)"

    def _deviate(self, name: str) -> str:
        self.names["normal_deviate"] = normal_deviate
        divisor = self.plan.schedule.divisors[name]
        tick = "tick" if divisor == 1 else f"tick // {divisor}"
        stream = self._constant((name, "stream"), int, self.plan.stream(name))
        return f"{_word(name)}__normal = normal_deviate(seed, run, {stream}, {tick})"

    def _constant(self, key: Any, kind: type, value: Any) -> str:
        self.values[key] = value
        return self.constants.add(key, kind)

    def _named(self, block: Any, role: str, value: Any) -> str:
        """A name for a function or class of a kind of block; two kinds may bear the same name, and any letters."""
        kind = type(block).__name__
        name = plain = f"{kind[0].upper()}{kind[1:]}__{role}"
        number = 1
        while self.names.setdefault(name, value) is not value:
            number += 1
            name = f"{plain}_{number}"
        return name


def _fields(made: Any) -> list[tuple[str, type]]:
    return list(made.__annotations__.items())


def _array(kind: type) -> str:
    return FLOATS if kind is float else INTEGERS


def _word(name: str) -> str:
    """The name of a block as part of a variable's; no block lies inside another, so that two never agree."""
    return name.replace(".", "__")


def _variable(node: Node) -> str:
    return f"{_word(node[0])}__{node[1]}"


def _entries(node: Node, shape: tuple[int, ...]) -> list[str]:
    """The numbers that a wire holds."""
    return [f"{_variable(node)}[{i}]" for i in range(shape[0])] if shape else [_variable(node)]
