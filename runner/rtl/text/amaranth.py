"""Modules of a machine as Amaranth Elaboratables: the operations of the Verilog, for designs written in Amaranth.

Amaranth's arithmetic is exact, so a signal is as wide as the range of its value, and unsigned if
that has no negative number. Ports are attributes; `sync` is clock and reset.
"""

from collections.abc import Generator, Iterator

from proofmass.runner.fixed.integer_ir import Operation, SourceLine
from proofmass.runner.fixed.operations import OPERATIONS
from proofmass.runner.rtl.machine.low_bits import operands_of
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.words import VerilogNames, Word
from proofmass.runner.rtl.text.machine_verilog import top_name
from proofmass.runner.rtl.text.verilog import about, first_line, line_comment

_HEAD = '''\
"""Digital blocks of {name} as Amaranth modules."""

from amaranth.hdl import Const, Elaboratable, Module, Mux, Signal, signed
'''
_OWN = ("m", "self", "platform", "enable", "Const", "Module", "Mux", "Signal", "signed")


def amaranth_files(machine: Machine) -> dict[str, str]:
    """The file of the modules by its name; their top is not among them."""
    texts = [_HEAD.format(name=machine.name), *("\n".join(_Writer(each).lines()) for each in machine.modules)]
    return {
        f"{top_name(machine)}_amaranth.py": "\n\n".join(f"{text}\n" if text[-1] != "\n" else text for text in texts)
    }


def class_name(module: Module) -> str:
    """The class of a module: its name without underscores.

    >>> class_name(type("", (), {"name": "fixed_gain_modelled"}))
    'FixedGainModelled'
    """
    return "".join(part[:1].upper() + part[1:] for part in module.name.split("_"))


class _Writer:
    """The lines of one class, and the names in it."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self._names = VerilogNames(_OWN)
        self._ports = {p.name: f"self.{self._names.add(p.name)}" for p in (*module.inputs, *module.outputs)}
        self._registers = {register.name: self._names.add(register.name) for register in module.registers}
        self._texts: dict[Operation, list[str]] = {}  # names of an operation as it comes, and for each later tick
        self._moves: list[tuple[str, str]] = []  # registers of the pipeline, and their next values
        self._count = 0
        self._told: set[SourceLine] = set()

    def lines(self) -> Iterator[str]:
        module, block = self.module, type(self.module.block)
        yield f"class {class_name(module)}(Elaboratable):"
        yield f'    """{block.__name__}: {first_line(block.__doc__ or "")}"""'
        yield ""
        yield "    def __init__(self):"
        if module.clocked:
            yield "        self.enable = Signal()"
        for port in (*module.inputs, *module.outputs):
            yield f"        {self._ports[port.name]} = {_signal(port.word, self._named(port.name))}  # {about(port)}"
        yield ""
        yield "    def elaborate(self, platform):"
        yield "        m = Module()"
        for register in module.registers:
            name = self._registers[register.name]
            signal = _signal(register.word, self._named(register.name), f"init={register.start}")
            yield f"        {name} = {signal}  # {register.text} {register.word}"
        for operation in module.needed:
            yield from self._operation(operation)
        yield from self._clocked()
        for port in module.outputs:
            value = self._text(module.results[port.name], module.pipeline.latency)
            yield f"        m.d.comb += {self._ports[port.name]}.eq({value})"
        yield "        return m"

    def _named(self, name: str) -> str:
        """Comment with the name in Python of a port or register, if the name in Verilog differs."""
        python = self._registers.get(name) or self._ports[name]
        return "" if python.removeprefix("self.") == name else f'name="{name}"'

    def _operation(self, operation: Operation) -> Iterator[str]:
        """Write a signal for each operation, and registers if it is taken later."""
        if operation.kind == "input":
            source = self.module.sources[operation.name].name
            name = self._registers.get(source) or self._ports[source]
        else:
            name = yield from self._computed(operation)
        names = [name]
        for k in range(1, self.module.pipeline.delays.get(operation, 0) + 1):
            names.append(self._names.add(f"{name.removeprefix('self.')}_late_{k}"))
            yield f"        {names[-1]} = {_signal(_word(operation), 'reset_less=True')}"
            self._moves.append((names[-1], names[-2]))
        self._texts[operation] = names

    def _computed(self, operation: Operation) -> Generator[str, None, str]:
        self._count += 1
        name = self._names.add(f"{OPERATIONS[operation.kind].word}_{self._count}")
        stage = self.module.pipeline.stages[operation] - (operation.kind == "pipe")
        operands = operands_of(operation)
        texts = [self._text(each, stage) for each in operands]
        if len(operands) < len(operation.operands):
            value = f"{texts[0]}[:{operation.width}].as_signed()"  # low bits, two's complement
        else:
            value = OPERATIONS[operation.kind].in_amaranth(*texts)
        comment = line_comment(operation.place, self._told, "#")
        if operation.kind == "pipe":
            yield f"        {name} = {_signal(_word(operation), 'reset_less=True')}{comment}"
            self._moves.append((name, value))
        else:
            yield f"        {name} = {_signal(_word(operation))}"
            yield f"        m.d.comb += {name}.eq({value}){comment}"
        return name

    def _clocked(self) -> Iterator[str]:
        """Write the next values of registers; those after cuts wait until the first values have come through."""
        pipeline = self.module.pipeline
        ready = [self._names.add(f"ready_{k}") for k in range(1, pipeline.waits + 1)]
        yield from (f"        {name} = Signal()" for name in ready)
        if self.module.clocked:
            yield "        with m.If(self.enable):"
        moves = [*self._moves, *zip(ready, ["1", *ready], strict=False)]
        yield from (f"            m.d.sync += {name}.eq({taken})" for name, taken in moves)
        for register in self.module.registers:
            stage = pipeline.registers[register.name]
            value = self._text(self.module.following[register.name], stage)
            move = f"m.d.sync += {self._registers[register.name]}.eq({value})"
            if stage:
                yield f"            with m.If({ready[stage - 1]}):"
            yield f"            {'    ' if stage else ''}{move}"

    def _text(self, operation: Operation, stage: int) -> str:
        if operation.constant is not None:
            return f"Const({operation.constant})"
        return self._texts[operation][stage - self.module.pipeline.stages[operation]]


def _word(operation: Operation) -> Word:
    return Word(operation.low, operation.high)


def _signal(word: Word, *more: str) -> str:
    shape = f"signed({word.width})" if word.signed else str(word.width)
    return f"Signal({', '.join([shape, *filter(None, more)])})"
