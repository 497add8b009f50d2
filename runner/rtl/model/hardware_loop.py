"""The program of the ticks with a compiled model of the hardware in the place of the digital blocks.

Registers of the model are written before the first tick and read after the last, so that the memory
is that of every engine. In a tick the model settles before the first of its outputs that is read
after an input was written. After all updates it is clocked.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from typing import NamedTuple

from proofmass.graphs.checks.schedule import Beat, outputs_of
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.plan.keys import HardwareModel
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.build import operand
from proofmass.runner.program.due import when_due
from proofmass.runner.program.form import INTEGER, Operand, Storage, Variable
from proofmass.runner.program.lower_numbers import as_kind
from proofmass.runner.program.structure import Lowered
from proofmass.runner.program.tick import TickWriter
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.model.cxxrtl import VerilogModel


class MemoryPlace(NamedTuple):
    """Place of a hardware's number in the memory: a wire, an entry of one, or a state's field."""

    node: Endpoint
    entry: int | None = None
    of_state: bool = False


class HardwareTickWriter(TickWriter):
    """Writes the ticks around a model of a machine."""

    def __init__(self, plan: Plan, machine: Machine, model: VerilogModel) -> None:
        super().__init__(plan)
        self._machine, self._model = machine, model
        self._paths = {instance.path for instance in machine.instances}
        self._ticks = int(plan.schedule.base_rate / machine.rate)  # from one clock to the next
        self._outputs_of = {_place(port.text): number for number, port in enumerate(machine.outputs)}
        ports = ({_place(port.text).node for port in each} for each in (machine.inputs, machine.outputs))
        self._settled = settled_before(outputs_of(plan.schedule.order), plan.stride, *ports)

    def begin(self) -> None:
        super().begin()
        self._hardware = self.numbers.constant(HardwareModel(), int, self._model.address)
        numbers = [self._register(place) for place in self._places()]
        for number, value in enumerate([*numbers, *self._counts()]):
            self._call("set_register", number, value)

    def constants_of(self, name: str) -> None:
        if name not in self._paths:
            super().constants_of(name)

    def output(self, name: str, port: str) -> None:
        if name not in self._paths:
            super().output(name, port)
            return
        if (name, port) in self._settled:
            self._call("settle", *self._inputs())
        for place, number in self._outputs_of.items():
            if place.node == (name, port):
                self._write(place, self._call("output", number))

    def update(self, name: str) -> None:
        if name not in self._paths:
            super().update(name)

    def updates(self) -> None:
        super().updates()
        if self._machine.clocked:
            when_due(self.frame, [(Beat(self._ticks), lambda: self._call("clock", *self._inputs()))])

    def finish(self) -> None:
        for number, place in enumerate(self._places()):
            self._write(place, self._call("register", number))
        super().finish()

    def _places(self) -> Iterator[MemoryPlace]:
        """Places of the registers of the model, in their order; those of `_counts` follow."""
        for instance in self._machine.instances:
            for register in instance.module.registers:
                head, _, field = register.text.partition(".")
                if head == "x":
                    yield MemoryPlace((instance.path, field), None, True)
                else:
                    yield _place(f"{instance.path}.{register.text}")
        yield from (_place(net.signal) for net in self._machine.nets.values() if net.kept)

    def _counts(self) -> Iterator[Operand]:
        """Count how often each counter was enabled."""
        compute = self.builder.compute
        for _, over, last in self._machine.counters:
            past = compute("floor_divide", compute("subtract_integers", 0, self.first), self._ticks * over)
            yield compute("modulo", compute("subtract_integers", 0, past), last + 1)

    def _held(self, place: MemoryPlace) -> Lowered:
        if place.of_state:
            block, field = place.node
            return getattr(self.frame.states[block], field)
        return self.frame.wires[place.node]

    def _register(self, place: MemoryPlace) -> Operand:
        held = self._held(place)
        value = self.builder.load(held, place.entry or 0) if isinstance(held, Storage) else self.frame.now(held)
        return as_kind(self.builder, value, INTEGER)

    def _write(self, place: MemoryPlace, value: Operand) -> None:
        storage = self._held(place)
        if isinstance(storage, Variable):
            self.builder.set(storage, as_kind(self.builder, value, storage.kind))
        else:
            self.builder.store(storage, place.entry or 0, value)

    def _call(self, name: str, *given: Operand | int) -> Operand:
        results = self.builder.call(self._model.function(name), self._hardware, *given)
        return results[0] if results else operand(0)

    def _inputs(self) -> list[Operand]:
        return [self._register(_place(port.text)) for port in self._machine.inputs]


def settled_before(
    order: Iterable[Endpoint],
    stride: Callable[[Endpoint], int],
    inputs: Collection[Endpoint],
    outputs: Collection[Endpoint],
) -> frozenset[Endpoint]:
    """Return the outputs of hardware before which it must settle, from all outputs of a tick in order.

    It need not settle again if it did so after the last input, in all ticks in which the output is
    due.

    >>> order = [("a", "early"), ("adc", "code"), ("b", "now"), ("b", "too")]
    >>> sorted(settled_before(order, lambda node: 1, {("adc", "code")}, {("a", "early"), ("b", "now"), ("b", "too")}))
    [('a', 'early'), ('b', 'now')]
    """
    settled, strides = set[Endpoint](), list[int]()  # of ticks in which it has settled
    for node in order:
        if node in inputs:
            strides = []
        elif node in outputs and all(stride(node) % each for each in strides):
            settled.add(node)
            strides.append(stride(node))
    return frozenset(settled)


def _place(text: str) -> MemoryPlace:
    """The place of a port or net: an output of the graph, or an entry of one or of a buffer."""
    node, _, entry = text.partition("[")
    return MemoryPlace(split(node), int(entry.rstrip("]")) if entry else None)
