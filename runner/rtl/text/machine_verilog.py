"""The machine as Verilog-2001: its modules, and a top module that joins them and divides the clock.

Counters make the enables: `tick_512` is high in one of 512 enabled clocks, beginning with the first
after a reset. A kept net has three names: `x_now` from its block, the register `x_kept`, and `x`
for its readers. A net that is read later than it comes has registers `x_late_1`, `x_late_2` and so
on; late blocks begin to move when `ready` is high.
"""

from collections.abc import Iterator

from proofmass.runner.rtl.machine.machine import Instance, Machine, OutputNet
from proofmass.runner.rtl.machine.names import TopNames
from proofmass.runner.rtl.machine.words import Word
from proofmass.runner.rtl.text.expressions import fitted
from proofmass.runner.rtl.text.verilog import declared, header, module_text


def machine_text(machine: Machine, *, keep_adders: bool = True) -> str:
    """Return all modules of the machine, the top last; a single block is its own top."""
    texts = [module_text(module, keep_adders=keep_adders) for module in machine.modules]
    if not machine.single:
        texts.append("\n".join(_Top(machine).lines()) + "\n")
    return "\n".join(texts)


def top_name(machine: Machine) -> str:
    """Return the name of the top module."""
    return machine.modules[0].name if machine.single else machine.name


class _Top:
    """Lines of the top module."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        names = TopNames(machine)
        self.ticks, self.counts, self.now, self.kept = names.ticks, names.counts, names.now, names.kept
        self.ready, self.late = names.ready, names.late
        self.given, self.outputs = names.given, names.outputs

    def lines(self) -> Iterator[str]:
        machine = self.machine
        yield f"// {machine.name}: clock enabled at {machine.rate} Hz"
        yield from header(machine.name, machine.clocked, machine.inputs, machine.outputs)
        yield from self._enables()
        ports = {port.name for port in (*machine.inputs, *machine.outputs)}
        for net in machine.nets.values():
            if net.kept:
                yield f"    {declared('wire', net.word, self.now[net])};"
                yield f"    {declared('reg', net.word, self.kept[net])};"
            if self.given[net] not in ports:
                yield f"    {declared('wire', net.word, self.given[net])};"
        yield from self._delays()
        for instance in machine.instances:
            yield from self._instance(instance)
        for net in self.now:
            yield f"    assign {net.name} = {self._due(net)} ? {self.now[net]} : {self.kept[net]};"
            yield from self._register(self.kept[net], net.word, self._due(net), self.now[net])
        yield "endmodule"

    def _due(self, net: OutputNet) -> str:
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
        if module.clocked:
            rows = ["        .clock(clock)", "        .reset(reset)"]
            rows.append(f"        .enable({self._enable(instance)})")
        words = {port.name: port.word for port in module.inputs}
        for port, net in instance.inputs.items():
            value = fitted(net, words[port]) if isinstance(net, int) else self._taken(net, instance.stage)
            rows.append(f"        .{port}({value})")
        rows += [f"        .{port}({self.now.get(net, self.given[net])})" for port, net in instance.outputs.items()]
        yield f"    {module.name} {instance.name} (  // {type(module.block).__name__} {instance.path}"
        yield ",\n".join(rows)
        yield "    );"

    def _enable(self, instance: Instance) -> str:
        """Enable of a block; of a late block, only once its first inputs have come."""
        tick = self.ticks.get(instance.stride, "enable")
        return f"{tick} && {self.ready[instance.stage - 1]}" if instance.stage and instance.module.registers else tick

    def _taken(self, net: OutputNet, stage: int) -> str:
        return self.late[net][stage - net.stage - 1] if stage > net.stage else self.given[net]

    def _delays(self) -> Iterator[str]:
        """Write the registers of delayed nets, and the signal that the first inputs of late blocks have come."""
        for name, before in zip(self.ready, ["1'b1", *self.ready], strict=False):
            yield f"    reg {name};"
            yield from self._register(name, Word(0, 1), "enable", before)
        for net, names in self.late.items():
            for name, before in zip(names, [self.given[net], *names], strict=False):
                yield f"    {declared('reg', net.word, name)};"
                yield "    always @(posedge clock)"
                yield f"        if (enable) {name} <= {before};"
            if net.signal in self.outputs and self.given[net] != net.name:
                yield f"    assign {net.name} = {self._taken(net, self.machine.latency)};"

    def _register(self, name: str, word: Word, enable: str, value: str) -> Iterator[str]:
        yield "    always @(posedge clock)"
        yield f"        if (reset) {name} <= {fitted(0, word)};"
        yield f"        else if ({enable}) {name} <= {value};"
