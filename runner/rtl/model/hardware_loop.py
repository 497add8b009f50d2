"""The generated loop with a compiled model of the hardware in the place of the digital blocks.

Registers of the model are written before the first tick and read behind the last, so that what moves stands where every
engine has it. In a tick the model settles before the first of its outputs that is read after an input was written, and
behind all updates it is clocked.
"""

from collections.abc import Callable, Collection, Iterable, Iterator

from proofmass.graphs.checks.schedule import Node, outputs_of
from proofmass.graphs.model.graph import split
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.keys import HardwareModel, made_up, variable, word
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.generate import LoopGenerator, when_due
from proofmass.runner.program.pieces import fields
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.model.cxxrtl import Model


class HardwareLoopGenerator(LoopGenerator):
    """Writes the loop around a model of a machine."""

    def __init__(self, plan: Plan, machine: Machine, model: Model) -> None:
        super().__init__(plan)
        self._machine, self._model = machine, model
        self._paths = [instance.path for instance in machine.instances]
        self._ticks = int(plan.schedule.base_rate / machine.rate)  # from one clock to the next
        self._outputs_of = {_place(port.text): number for number, port in enumerate(machine.outputs)}
        self._registers = {place: number for number, place in enumerate(self._places())}
        ports = ({_node(port.text) for port in each} for each in (machine.inputs, machine.outputs))
        self._settled = settled_before(outputs_of(plan.schedule.order), plan.stride, *ports)

    def _unpacked(self) -> Iterator[str]:
        yield from super()._unpacked()
        yield f"hardware = {self.constant(HardwareModel(), int, self._model.address)}"
        for place, number in self._registers.items():
            yield self._call("set_register", number, place)

    def _constants_of(self, name: str) -> Iterator[str]:
        return iter(()) if name in self._paths else super()._constants_of(name)

    def _kept(self, name: str, function: str, target: str) -> Iterator[str]:
        if name not in self._paths:
            yield from super()._kept(name, function, target)
        elif function != "update":
            if (name, function) in self._settled:
                yield self._call("settle", *self._given())
            for place in self._entries((name, function)):
                if place in self._outputs_of:
                    yield f"{place} = {self._read('output', self._outputs_of[place], self._kind((name, function)))}"

    def _updates(self) -> Iterator[str]:
        yield from super()._updates()
        if self._machine.clocked:
            yield from when_due([(self._ticks, self._call("clock", *self._given()))])

    def _packed(self) -> Iterator[str]:
        for instance in self._machine.instances:
            block, x = instance.module.block, made_up(word(instance.path), "x")
            state = type(block).state_class()
            if state is not None:
                held = (self._held(f"{x}.{field}", held_as(kind)) for field, kind in fields(state))
                yield f"{x} = {self.named(block, 'State', state)}({', '.join(held)})"
            for register in instance.module.registers:
                if not register.text.startswith("x."):
                    place = _place(f"{instance.path}.{register.text}")
                    yield f"{place} = {self._held(place, int)}"
        for net in self._machine.nets.values():
            if net.kept:
                yield f"{_place(net.signal)} = {self._held(_place(net.signal), self._kind(_node(net.signal)))}"
        yield from super()._packed()

    def _places(self) -> Iterator[str]:
        """What each register of the model holds, in their order."""
        for instance in self._machine.instances:
            for register in instance.module.registers:
                head, _, field = register.text.partition(".")
                x = made_up(word(instance.path), "x")
                yield f"{x}.{field}" if head == "x" else _place(f"{instance.path}.{register.text}")
        yield from (_place(net.signal) for net in self._machine.nets.values() if net.kept)
        for _, over, last in self._machine.counters:
            yield f"-(-first // {self._ticks * over}) % {last + 1}"  # times that it was enabled

    def _held(self, place: str, kind: type) -> str:
        """What is in a place behind the last tick: of what has no register, what was there before."""
        return self._read("register", self._registers[place], kind) if place in self._registers else place

    def _read(self, function: str, number: int, kind: type) -> str:
        return self._call(function, number) + (" != 0" if kind is bool else "")

    def _call(self, function: str, *given: object) -> str:
        self.names[function] = self._model.function(function)
        return f"{function}({', '.join(map(str, ('hardware', *given)))})"

    def _given(self) -> list[str]:
        return [_place(port.text) for port in self._machine.inputs]

    def _kind(self, node: Node) -> type:
        return held_as(type(self.plan.blocks[node[0]]).outputs[node[1]].dtype)


def settled_before(
    order: Iterable[Node], stride: Callable[[Node], int], inputs: Collection[Node], outputs: Collection[Node]
) -> frozenset[Node]:
    """Outputs of hardware before which it has to settle, of all that are computed in a tick in that order.

    It has settled where it did so after the last input, in all ticks in which the output is due.

    >>> order = [("a", "early"), ("adc", "code"), ("b", "now"), ("b", "too")]
    >>> sorted(settled_before(order, lambda node: 1, {("adc", "code")}, {("a", "early"), ("b", "now"), ("b", "too")}))
    [('a', 'early'), ('b', 'now')]
    """
    found, strides = set[Node](), list[int]()  # of ticks in which it has settled
    for node in order:
        if node in inputs:
            strides = []
        elif node in outputs and all(stride(node) % each for each in strides):
            found.add(node)
            strides.append(stride(node))
    return frozenset(found)


def _node(text: str) -> Node:
    """The output of the graph that a port or net is, or an entry of."""
    return split(text.partition("[")[0])


def _place(text: str) -> str:
    """The variable of a port, a net or an entry of a buffer."""
    return variable(_node(text)) + text[len(text.partition("[")[0]) :]
