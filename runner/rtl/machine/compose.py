"""From a planned graph to the machine of its digital part, or of some blocks of it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import get_type_hints

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.graphs.checks.schedule import outputs_of
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.rates import base_rate
from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.machine.alignment import block_stages
from proofmass.runner.rtl.machine.block_modules import BlockModules
from proofmass.runner.rtl.machine.machine import Instance, Machine, OutputNet
from proofmass.runner.rtl.machine.modules import CLOCKING, Module, entries
from proofmass.runner.rtl.machine.words import VerilogNames, VerilogPort


def compose(planned: Plan, only: Sequence[str] = (), name: str = "") -> Machine:
    """The machine of the digital blocks of a graph, or of some of them; raises `ModelError` with every problem.

    `only` names blocks, or subgraphs with all their blocks. Outputs are those that other blocks,
    probes and measures read; of named blocks, all outputs.
    """
    paths = _chosen(planned, only)
    return _Composer(planned, BlockModules(planned, paths).named(), bool(only)).machine(name or planned.graph.root.name)


def digital_blocks(planned: Plan) -> tuple[str, ...]:
    """Return the blocks of digital kinds whose parameters nothing drives."""
    driven = {path for path, port in planned.schedule.drivers if port in type(planned.blocks[path]).parameters}
    return tuple(name for name in sorted(planned.blocks) if fits_hardware(planned.blocks[name]) and name not in driven)


def fits_hardware(block: Block) -> bool:
    """Return whether ports and state of a block are all integers, without time or noise."""
    kind = type(block)
    state = kind.state_class()
    kinds: list[type] = [port.dtype for port in (*kind.inputs.values(), *kind.outputs.values())]
    kinds += [buffer.dtype for buffer in kind.buffers.values()]
    kinds += get_type_hints(state).values() if state is not None else []
    functions = (*kind.output_functions.values(), *kind.functions.values())
    return not (
        kind.continuous()
        or not kind.outputs
        or float in kinds
        or any({Meaning.TIME, Meaning.DEVIATE} & set(function.meanings) for function in functions)
    )


def _chosen(planned: Plan, only: Sequence[str]) -> list[str]:
    able = digital_blocks(planned)
    chosen = {name: [path for path in able if path == name or path.startswith(f"{name}.")] for name in only or able}
    problems = []
    for name in sorted(name for name, paths in chosen.items() if not paths):
        expected = "a block whose ports and state are integers, truth values or fixed-point values"
        hint = did_you_mean(name, able, "the digital blocks")
        problem = Problem(message="no such block", key=f"blocks.{name}", got=name, expected=expected, hint=hint)
        if name in planned.blocks:
            message, got = "is not a digital block, and cannot become hardware", type(planned.blocks[name]).__name__
            problem = Problem(message=message, got=got, expected=expected, hint=hint, path=("blocks", name))
        problems.append(planned.graph.placed(problem))
    if not able:
        hint = "put a FixedQuantiser behind what is analogue, and blocks whose names begin with Fixed behind that"
        problem = Problem(message="the graph has no digital blocks", hint=hint, path=("blocks",))
        problems.append(planned.graph.placed(problem))
    paths = sorted({path for paths in chosen.values() for path in paths})
    problems += [planned.graph.placed(_late(path)) for path in paths if path in planned.schedule.phases]
    if problems:
        raise ModelError(problems)
    return paths


def _late(path: str) -> Problem:
    """A clock offset, which hardware of one clock has not."""
    return Problem(
        message="has a clock offset, and cannot become hardware",
        expected="blocks that tick together at tick 0",
        hint="take the offset out, or delay the samples of the block by a FixedDelay",
        path=("blocks", path, "clock_offset"),
    )


class _Composer:
    """Makes nets, ports and instances around the modules of the blocks."""

    def __init__(self, planned: Plan, modules: Mapping[str, Module], all_outputs: bool) -> None:
        self.planned, self.modules = planned, modules
        schedule = planned.schedule
        self.clock = base_rate(schedule.base_rate / schedule.divisors[path] for path in modules)
        self.ticks = int(schedule.base_rate / self.clock)  # of the base rate, in a clock
        self.order = tuple(node for node in outputs_of(schedule.order) if node[0] in modules)
        self.drivers = {target: source for target, source in schedule.drivers.items() if target[0] in modules}
        outside = {source for target, source in schedule.drivers.items() if target[0] not in modules}
        outside |= {probe.node for probe in planned.probes} | {measure.node for measure in planned.measures}
        self.outside = outside | (set(self.order) - set(schedule.drivers.values()) if all_outputs else set())
        self.stages = block_stages(modules, self.drivers)
        self.names = VerilogNames(CLOCKING)
        self.nets: dict[str, OutputNet] = {}

    def machine(self, name: str) -> Machine:
        outputs = tuple(self._outputs())
        inputs = tuple(self._inputs())
        instances = tuple(self._instances())
        taken = VerilogNames(module.name for module in self.modules.values())
        made = Machine(taken.add(name), self.clock, inputs, outputs, instances, self.order, self.nets)
        if made.strides:
            self._refuse_cuts()
        return made

    def _outputs(self) -> Iterator[VerilogPort]:
        """Make the nets of the blocks; return the ports among them."""
        for node in self.order:
            stride = self.planned.stride(node) // self.ticks
            read = [self._stride(target[0]) for target, source in self.drivers.items() if source == node]
            registered = stride > 1 and (node in self.outside or any(each % stride for each in read))
            for port in entries(self.modules[node[0]].outputs, node[1]):
                signal = f"{node[0]}.{port.text}"
                stage = self.stages[node[0]] + self.modules[node[0]].pipeline.latency
                self.nets[signal] = OutputNet(self._named(port, signal), signal, port.word, stride, registered, stage)
                if node in self.outside:
                    yield VerilogPort(self.nets[signal].name, signal, port.word, port.unit, port.doc)

    def _inputs(self) -> Iterator[VerilogPort]:
        """Make the nets that come from outside; each is a port."""
        for target, source in sorted(self.drivers.items()):
            if source[0] not in self.modules:
                driver = type(self.planned.blocks[source[0]]).outputs[source[1]]
                for port in entries(self.modules[target[0]].inputs, target[1]):
                    signal = _signal(source, target[1], port)
                    if signal not in self.nets:
                        self.nets[signal] = OutputNet(self._named(port, signal), signal, port.word)
                        yield VerilogPort(self.nets[signal].name, signal, port.word, port.unit, driver.doc)

    def _instances(self) -> Iterator[Instance]:
        for path in dict.fromkeys(node[0] for node in self.order):
            module = self.modules[path]
            outputs = {port.name: self.nets[f"{path}.{port.text}"] for port in module.outputs}
            inputs = dict(self._connected(path, module))
            stage = self.stages[path]
            yield Instance(self.names.add(path), path, module, self._stride(path), inputs, outputs, stage)

    def _connected(self, path: str, module: Module) -> Iterator[tuple[str, OutputNet | int]]:
        for name, declared in type(module.block).inputs.items():
            for port in entries(module.inputs, name):
                source = self.drivers.get((path, name))
                if source is None:
                    yield port.name, int(declared.default)  # type: ignore[arg-type]
                else:
                    yield port.name, self.nets[_signal(source, name, port)]

    def _refuse_cuts(self) -> None:
        """Refuse cuts in a machine of several rates: all its blocks count the same ticks, so none may be late."""
        for path, module in self.modules.items():
            if module.pipeline.latency:
                problem = Problem(
                    message="a pipeline cut, and outputs at several rates",
                    hint=f"take the blocks of one rate, as with --block {path}, or keep the stages in the state",
                    path=("blocks", path),
                )
                raise self.planned.graph.placed(problem).error

    def _named(self, port: VerilogPort, signal: str) -> str:
        """The name of a net; for a single block, the name of its port."""
        return self.names.add(port.text if len(self.modules) == 1 else signal)

    def _stride(self, path: str) -> int:
        return self.planned.schedule.divisors[path] // self.ticks


def _signal(source: Endpoint, name: str, port: VerilogPort) -> str:
    """The entry of an output that an input's entry is wired to."""
    return ".".join(source) + port.text.removeprefix(name)
