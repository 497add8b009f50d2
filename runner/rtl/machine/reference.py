"""Reference of hardware in a clock: the Python functions of its blocks, run on numbers or on words of a proof.

It uses the functions, the graph and its schedule alone, as the interpreter does; no trace.
"""

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import where
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.fixed.step_formats import Format, bounds, filled, mantissas, reference_step
from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.machine.machine import Instance, Machine
from proofmass.runner.rtl.machine.modules import Module, entries
from proofmass.runner.rtl.machine.names import TopNames
from proofmass.runner.rtl.machine.words import Register, VerilogPort, Word

RegisterValues = Mapping[str, Any]  # by the names of ports and registers
Merge = Callable[[Callable[[], list[Any]]], list[Any]]  # runs a function and returns its results


@dataclass(frozen=True)
class ClockStep:
    """Outputs, and next values of registers if the clock is enabled."""

    outputs: RegisterValues
    following: RegisterValues


class Reference(ABC):
    """A module, or a whole machine, by the functions of its blocks; registers have the names of a flat netlist."""

    name: str
    clocked: bool
    inputs: tuple[VerilogPort, ...]
    outputs: tuple[VerilogPort, ...]
    registers: tuple[Register, ...]
    latency: int  # ticks by which the outputs of hardware are late

    @property
    def held(self) -> tuple[VerilogPort | Register, ...]:
        """Inputs and registers, on which a clock depends."""
        return (*self.inputs, *self.registers)

    @abstractmethod
    def clock(self, present: RegisterValues, merge: Merge) -> ClockStep:
        """Outputs and following registers for what inputs and registers are."""


def reference_of(planned: Plan, machine: Machine) -> Reference:
    """Return the reference of a machine."""
    return ModuleReference(machine.modules[0]) if machine.single else MachineReference(planned, machine)


def as_it_runs(run: Callable[[], list[Any]]) -> list[Any]:
    """Run a function on numbers, for which there is a single path."""
    return run()


class ModuleReference(Reference):
    """One block."""

    def __init__(self, module: Module) -> None:
        self.name, self.clocked = module.name, module.clocked
        self.inputs, self.outputs, self.registers = module.inputs, module.outputs, module.registers
        self.latency = module.pipeline.latency
        self._module = module

    def clock(self, present: RegisterValues, merge: Merge) -> ClockStep:
        texts = {each.text: present[each.name] for each in self.held}
        outputs = {}
        for name in type(self._module.block).outputs:
            results = _call(self._module, name, texts, merge)
            for port in entries(self.outputs, name):
                outputs[port.name] = results[port.text]
        return ClockStep(outputs, _stepped(self._module, texts, merge))


class MachineReference(Reference):
    """The digital blocks of a graph, wired and scheduled as the graph is."""

    def __init__(self, planned: Plan, machine: Machine) -> None:
        self.name, self.clocked = machine.name, machine.clocked
        self.inputs, self.outputs, self.latency = machine.inputs, machine.outputs, machine.latency
        self._planned, self._machine, self._names = planned, machine, TopNames(machine)
        self._instances = {each.path: each for each in machine.instances}
        self.registers = tuple(self._registers())

    def clock(self, present: RegisterValues, merge: Merge) -> ClockStep:
        due = self._due(present)
        nets = {self._machine.nets[port.text].signal: present[port.name] for port in self.inputs}
        following = dict[str, Any]()
        for node in self._machine.order:
            instance = self._instances[node[0]]
            results = _call(instance.module, node[1], self._texts(instance, present, nets), merge)
            for port in entries(instance.module.outputs, node[1]):
                net = instance.outputs[port.name]
                nets[net.signal] = results[port.text]
                if net.kept:
                    kept = self._names.kept[net]
                    nets[net.signal] = following[kept] = where(due[net.stride], results[port.text], present[kept])
        for instance in self._instances.values():
            stepped = _stepped(instance.module, self._texts(instance, present, nets), merge)
            for name, value in stepped.items():
                full = f"{instance.name}.{name}"
                following[full] = where(due[instance.stride], value, present[full])
        for stride, over, last in self._machine.counters:
            name = self._names.counts[stride]
            following[name] = where(due[over], where(present[name] == last, 0, present[name] + 1), present[name])
        return ClockStep({port.name: nets[port.text] for port in self.outputs}, following)

    def _registers(self) -> Iterator[Register]:
        for instance in self._machine.instances:
            for each in instance.module.registers:
                yield Register(f"{instance.name}.{each.name}", f"{instance.path}.{each.text}", each.word, each.start)
        for net, name in self._names.kept.items():
            yield Register(name, f"{net.signal} as it was", net.word, 0)
        for stride, over, last in self._machine.counters:
            yield Register(self._names.counts[stride], f"ticks of {over} in {stride}", Word(0, last), 0)

    def _due(self, present: RegisterValues) -> dict[int, Any]:
        """Return whether a clock is a tick of a stride."""
        due: dict[int, Any] = {1: 1}
        for stride, over, _ in self._machine.counters:
            due[stride] = where(present[self._names.counts[stride]] == 0, due[over], 0)
        return due

    def _texts(self, instance: Instance, present: RegisterValues, nets: RegisterValues) -> dict[str, Any]:
        """Values that a block reads, by the names in its functions, wired as in the graph."""
        module, texts = instance.module, dict[str, Any]()
        for register in module.registers:
            texts[register.text] = present[f"{instance.name}.{register.name}"]
        for name, declared in type(module.block).inputs.items():
            source: Endpoint | None = self._planned.schedule.drivers.get((instance.path, name))
            for port in entries(module.inputs, name):
                rest = port.text.removeprefix(name)
                if source is None:
                    texts[port.text] = int(declared.default)  # type: ignore[arg-type]
                elif (signal := f"{source[0]}.{source[1]}{rest}") in nets:
                    texts[port.text] = nets[signal]
        return texts


def _stepped(module: Module, texts: RegisterValues, merge: Merge) -> dict[str, Any]:
    """The registers of a module after a step, by their names."""
    found = _call(module, "update", texts, merge) if "update" in type(module.block).functions else {}
    after = {text.replace("return", "x", 1): value for text, value in found.items()}
    return {each.name: after.get(each.text, texts[each.text]) for each in module.registers}


def _call(module: Module, name: str, texts: RegisterValues, merge: Merge) -> dict[str, Any]:
    """Results of a function of a block, returned or written, by text: "output", "return.total", "history[3]"."""
    function = (type(module.block).output_functions.get(name) or type(module.block).functions[name]).function
    formats = module.steps[name].formats
    step = reference_step(function, formats)
    texts_of_results: list[str] = []

    def number(text: str, format: Format) -> Any:
        low, high = bounds(format)
        return low if low == high else texts.get(text)

    def run() -> list[Any]:
        arguments = {each: filled(formats[each], each, number) for each in inspect.signature(function).parameters}
        results = {"return": step(*arguments.values())}
        results |= {each: value for each, value in arguments.items() if isinstance(formats[each], list)}
        leaves = [leaf for each, raw in results.items() for leaf in mantissas(formats[each], raw, each)]
        texts_of_results[:] = [text for text, _ in leaves]
        return [value for _, value in leaves]

    values = merge(run)
    if name in type(module.block).outputs:
        texts_of_results = [_named(text, name) for text in texts_of_results]
    return dict(zip(texts_of_results, values, strict=True))


def _named(text: str, name: str) -> str:
    """The text of an output, which a function returns or writes into `out`."""
    head, bracket, rest = text.partition("[")
    return name + bracket + rest if head in ("out", "return") else text
