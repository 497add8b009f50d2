"""The machine as Verilog-2001: its modules, and a top module that joins them and divides the clock.

Counters make the enables: `tick_512` is high in one of 512 enabled clocks, the first behind a reset among them. A
kept net has three names: `x_now` from its block, the register `x_kept`, and `x` that is read.
"""

from collections.abc import Iterator

from proofmass.runner.rtl.expressions import fitted
from proofmass.runner.rtl.machine import Instance, Machine, Net
from proofmass.runner.rtl.modules import CLOCKING
from proofmass.runner.rtl.verilog import declared, header, module_text
from proofmass.runner.rtl.words import Names, Word


def machine_text(machine: Machine, *, keep_adders: bool = True) -> str:
    """All modules of the machine, the top last; of one block alone its module is all."""
    texts = [module_text(module, keep_adders=keep_adders) for module in machine.modules]
    if not machine.single:
        texts.append("\n".join(_Top(machine).lines()) + "\n")
    return "\n".join(texts)


def top_name(machine: Machine) -> str:
    """The name of the module that is the whole."""
    return machine.modules[0].name if machine.single else machine.name


def clocked(machine: Machine) -> bool:
    """Whether the whole has the ports clock, reset and enable."""
    return bool(machine.strides) or any(each.module.registers for each in machine.instances)


class TopNames:
    """Names of the wires and registers of the top module itself: enables, their counters, and kept nets."""

    def __init__(self, machine: Machine) -> None:
        names = Names([*CLOCKING, *(net.name for net in machine.nets.values())])
        for instance in machine.instances:
            names.add(instance.name)
        self.ticks = {stride: names.add(f"tick_{stride}") for stride in machine.strides}
        kept = [net for net in machine.nets.values() if net.kept]
        self.now = {net: names.add(f"{net.name}_now") for net in kept}
        self.kept = {net: names.add(f"{net.name}_kept") for net in kept}
        self.counts = {stride: names.add(f"count_{stride}") for stride in machine.strides}


class _Top:
    """Lines of the top module."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        names = TopNames(machine)
        self.ticks, self.now, self.kept, self.counts = names.ticks, names.now, names.kept, names.counts

    def lines(self) -> Iterator[str]:
        machine = self.machine
        yield f"// {machine.name}: clock enabled at {machine.rate} Hz"
        yield from header(machine.name, clocked(machine), machine.inputs, machine.outputs)
        yield from self._enables()
        ports = {port.name for port in (*machine.inputs, *machine.outputs)}
        for net in machine.nets.values():
            if net.kept:
                yield f"    {declared('wire', net.word, self.now[net])};"
                yield f"    {declared('reg', net.word, self.kept[net])};"
            if net.name not in ports:
                yield f"    {declared('wire', net.word, net.name)};"
        for instance in machine.instances:
            yield from self._instance(instance)
        for net in self.now:
            yield f"    assign {net.name} = {self._due(net)} ? {self.now[net]} : {self.kept[net]};"
            yield from self._register(self.kept[net], net.word, self._due(net), self.now[net])
        yield "endmodule"

    def _due(self, net: Net) -> str:
        return self.ticks[net.stride]

    def _enables(self) -> Iterator[str]:
        for stride, over, last in self.machine.counters:
            count, name = Word(0, last), self.counts[stride]
            enable, zero = self.ticks.get(over, "enable"), fitted(0, count)
            following = f"({name} == {fitted(last, count)}) ? {zero} : {name} + 1'd1"
            yield f"    {declared('reg', count, name)};"
            yield f"    wire {self.ticks[stride]} = {enable} && {name} == {zero};"
            yield from self._register(name, count, enable, following)

    def _instance(self, instance: Instance) -> Iterator[str]:
        module = instance.module
        rows = []
        if module.registers:
            rows = ["        .clock(clock)", "        .reset(reset)"]
            rows.append(f"        .enable({self.ticks.get(instance.stride, 'enable')})")
        words = {port.name: port.word for port in module.inputs}
        for port, net in instance.inputs.items():
            value = fitted(net, words[port]) if isinstance(net, int) else net.name
            rows.append(f"        .{port}({value})")
        rows += [f"        .{port}({self.now.get(net, net.name)})" for port, net in instance.outputs.items()]
        yield f"    {module.name} {instance.name} (  // {type(module.block).__name__} {instance.path}"
        yield ",\n".join(rows)
        yield "    );"

    def _register(self, name: str, word: Word, enable: str, value: str) -> Iterator[str]:
        yield "    always @(posedge clock)"
        yield f"        if (reset) {name} <= {fitted(0, word)};"
        yield f"        else if ({enable}) {name} <= {value};"
