"""A program in LLVM's language, as text: what makes machine code, WebAssembly and code of GPUs read it.

A variable is a place on the stack, which LLVM's first passes make a value of; all else is written
as values straight away. Nothing is contracted or reordered: no instruction has a flag for that.
"""

import hashlib
from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from proofmass.runner.program import form
from proofmass.runner.program.shared import shared
from proofmass.runner.targets.llvm_functions import ATTRIBUTES, attributes_of, declared, result_type, symbol_of
from proofmass.runner.targets.llvm_operations import (
    NATIVE,
    TYPES,
    ZEROS,
    Template,
    cannot_overflow,
    constant,
    power_of_two,
    select,
)
from proofmass.runner.targets.turns import written_out

ENTRY = "proofmass_program"
STORED = {form.FLOAT: "double", form.INTEGER: "i64", form.TRUTH: "i8"}  # in arrays
BYTES = {form.FLOAT: 8, form.INTEGER: 8, form.TRUTH: 1}
_SELECTS = {kind: select(kind) for kind in (form.FLOAT, form.INTEGER, form.TRUTH)}
_LIKELY = '!0 = !{!"branch_weights", i32 2000, i32 1}'
_SHORT = '!1 = distinct !{!1, !2}\n!2 = !{!"llvm.loop.unroll.disable"}'
_LONGEST = 1000  # statements of a region in one block of instructions


def llvm_text(
    program: form.Program, triple: str = "", layout: str = "", operations: Mapping[str, Template] = NATIVE
) -> str:
    """The module of a program; its entry is called `ENTRY`.

    Other functions have numbers for names, so that programs that do the same have the same text.
    """
    beside: dict[str, None] = {}  # declarations and helpers
    entry, once, own = program.entry, shared(program), program.functions.values()
    symbols = {function: f"@f.{number}" for number, function in enumerate(own)} | {entry: f"@{ENTRY}"}
    functions = [FunctionText(f, f is entry, beside, operations, once, symbols).text() for f in own]
    head = [f'target triple = "{triple}"', f'target datalayout = "{layout}"'] if triple else []
    return "\n".join([*head, *beside, *functions, *ATTRIBUTES, ""])


def content_of(program: form.Program) -> str:
    """Hash of everything that a program computes, whatever files its functions come from: the same on every machine."""
    return hashlib.sha256(llvm_text(program).encode()).hexdigest()


class LoopLabels(NamedTuple):
    """Targets of Continue and Break; for lanes that leave a loop apart, places of the masks of those that are in it."""

    turn: str
    end: str
    base: str = ""  # mask of all lanes of the turn
    live: str = ""  # place of the lanes that will take the next turn
    active: str = ""  # place of the lanes that have not left this turn


class FunctionText:
    """One function; `beside` takes in what it needs of others."""

    def __init__(
        self,
        function: form.Function,
        is_entry: bool,
        beside: dict[str, None],
        operations: Mapping[str, Template] = NATIVE,
        once: Collection[form.Function] = (),
        symbols: Mapping[form.Function, str] = MappingProxyType({}),
    ) -> None:
        self.function, self.is_entry, self.beside, self.operations = function, is_entry, beside, operations
        self.once, self.symbols = once, symbols  # functions that are shared, and what each is called
        self.lines: list[str] = []
        self.names: dict[form.Value | form.Variable | form.Storage, str] = {}
        self.count = 0
        self.block = "entry"  # the label of the block that is being written; "" behind a jump
        self.loops: list[LoopLabels] = []  # the loops around a statement
        self.expected: set[form.Operand] = set()  # conditions that hold as a rule

    def text(self) -> str:
        """Definition of the function."""
        parameters = ", ".join(self._parameter(p) for p in self.function.parameters)
        how = "" if self.is_entry else "internal fastcc "
        attributes = "#0" if self.is_entry else attributes_of(self.function, self.once)
        returned = result_type(self.function.results)
        if self.is_entry and returned == "i1":
            returned = "zeroext i1"  # as C has it
        head = f"define {how}{returned} {self.symbols[self.function]}({parameters})"
        for variable in self.function.variables:
            place, kind = self._named(variable), variable.kind
            self.lines.append(f"{place} = alloca {TYPES[kind]}")
            self.lines.append(f"store {TYPES[kind]} {ZEROS[kind]}, ptr {place}")
        integer = next(
            (p for p in self.function.parameters if isinstance(p, form.Value) and p.kind is form.INTEGER), None
        )
        if integer is None:
            self.region(self.function.body)
        else:
            self._long_region(self.function.body, self.names[integer])
        if self.block:
            self.lines.append("unreachable" if self.function.results else "ret void")
        return "\n".join([f"{head} {attributes} {{", "entry:", *self.lines, "}"])

    def _parameter(self, parameter: form.Value | form.Storage) -> str:
        name = self._named(parameter)
        if isinstance(parameter, form.Value):
            extended = "zeroext " if self.is_entry and parameter.kind is form.TRUTH else ""
            return f"{TYPES[parameter.kind]} {extended}{name}"
        size = (parameter.length or 0) * BYTES[parameter.entry]
        facts = "noalias " if self.is_entry or self.function.apart else ""
        facts += "" if parameter.writable else "readonly "
        facts += f"dereferenceable({size}) " if size else ""
        return f"ptr {facts}nonnull align {BYTES[parameter.entry]} {name}"

    # -- names and numbers -------------------------------------------------------------------------

    def _named(self, item: form.Value | form.Variable | form.Storage) -> str:
        self.count += 1
        name = self.names[item] = f"%v{self.count}"
        return name

    def _fresh(self) -> str:
        self.count += 1
        return f"%v{self.count}"

    def _operand(self, operand: form.Operand) -> str:
        return constant(operand) if isinstance(operand, form.Immediate) else self.names[operand]

    def _typed(self, operand: form.Operand) -> str:
        return f"{TYPES[operand.kind]} {self._operand(operand)}"

    def _need(self, texts: Iterable[str]) -> None:
        for text in texts:
            self.beside[text] = None

    # -- blocks ------------------------------------------------------------------------------------

    def _label(self) -> str:
        self.count += 1
        return f"b{self.count}"

    def _begin(self, label: str) -> None:
        self.lines.append(f"{label}:")
        self.block = label

    def _jump(self, label: str) -> None:
        if self.block:
            self.lines.append(f"br label %{label}")
            self.block = ""

    def _branch(self, condition: str, yes: str, no: str, weights: str = "") -> None:
        self.lines.append(f"br i1 {condition}, label %{yes}, label %{no}{weights}")
        self.block = ""

    def _weights(self, condition: form.Operand) -> str:
        """Return the weights of a condition's branches; where it nearly always holds, LLVM's last passes branch."""
        if condition not in self.expected:
            return ""
        self._need((_LIKELY,))
        return ", !prof !0"

    # -- statements --------------------------------------------------------------------------------

    def _statement(self, statement: form.Statement) -> None:
        """Write a statement by the method that is named after its class."""
        getattr(self, f"_{type(statement).__name__.lower()}")(statement)

    def region(self, region: form.Region) -> None:
        """Statements up to the first behind which nothing is reached."""
        for statement in region:
            if not self.block:
                return
            self._statement(statement)

    def _compute(self, s: form.Compute) -> None:
        read = [self._operand(operand) for operand in s.operands]
        if s.operation == "likely":
            self.names[s.result] = read[0]
            self.expected.add(s.result)
            return
        if s.operation == "select":
            text = _SELECTS[s.result.kind] + self._weights(s.operands[0])
        elif s.operation in ("floor_divide", "modulo") and (shift := power_of_two(s.operands[1])) is not None:
            text = "%s = ashr i64 %s, %s" if s.operation == "floor_divide" else "%s = and i64 %s, %s"
            read[1] = str(shift) if s.operation == "floor_divide" else str((1 << shift) - 1)
        else:
            text, needs = self.operations[s.operation]
            if needs:
                self._need(needs)
        self.lines.append(text % (self._named(s.result), *read))

    def _get(self, s: form.Get) -> None:
        self.lines.append(f"{self._named(s.result)} = load {TYPES[s.result.kind]}, ptr {self.names[s.variable]}")

    def _set(self, s: form.Set) -> None:
        self.lines.append(f"store {self._typed(s.value)}, ptr {self.names[s.variable]}")

    def _place(self, array: form.Storage, index: form.Operand) -> str:
        base = self.names[array]
        if isinstance(index, form.Immediate) and not index.value:
            return base
        place = self._fresh()
        self.lines.append(f"{place} = getelementptr inbounds {STORED[array.entry]}, ptr {base}, {self._typed(index)}")
        return place

    def _load(self, s: form.Load) -> None:
        place, kind = self._place(s.array, s.at), s.array.entry
        if kind is form.TRUTH:
            byte = self._fresh()
            self.lines.append(f"{byte} = load i8, ptr {place}")
            self.lines.append(f"{self._named(s.result)} = icmp ne i8 {byte}, 0")
        else:
            self.lines.append(f"{self._named(s.result)} = load {TYPES[kind]}, ptr {place}, align 8")

    def _store(self, s: form.Store) -> None:
        place, kind = self._place(s.array, s.at), s.array.entry
        if kind is form.TRUTH:
            byte = self._fresh()
            self.lines.append(f"{byte} = zext i1 {self._operand(s.value)} to i8")
            self.lines.append(f"store i8 {byte}, ptr {place}")
        else:
            self.lines.append(f"store {self._typed(s.value)}, ptr {place}, align 8")

    def _view(self, s: form.View) -> None:
        self.names[s.part] = self._place(s.whole, s.first)

    def _call(self, s: form.Call) -> None:
        if isinstance(s.function, form.External):
            how, symbol = "", f"@{symbol_of(s.function)}"
            returned = "void" if s.function.result is None else TYPES[s.function.result]
            self._need((declared(s.function),))
        else:
            how, symbol, returned = "fastcc ", self.symbols[s.function], result_type(s.function.results)
        read = ", ".join(f"ptr {self.names[a]}" if isinstance(a, form.Storage) else self._typed(a) for a in s.arguments)
        call = f"call {how}{returned} {symbol}({read})"
        if not s.results:
            self.lines.append(call)
        elif len(s.results) == 1:
            self.lines.append(f"{self._named(s.results[0])} = {call}")
        else:
            several = self._fresh()
            self.lines.append(f"{several} = {call}")
            for place, result in enumerate(s.results):
                self.lines.append(f"{self._named(result)} = extractvalue {returned} {several}, {place}")

    def _if(self, s: form.If) -> None:
        yes, no, end = self._label(), self._label(), self._label()
        self._branch(self._operand(s.condition), yes, no if s.otherwise else end, self._weights(s.condition))
        reached = not s.otherwise
        for label, region in ((yes, s.then), (no, s.otherwise)):
            if region or label == yes:
                self._begin(label)
                self.region(region)
                reached |= bool(self.block)
                self._jump(end)
        if reached:
            self._begin(end)

    def _for(self, s: form.For) -> None:
        """For: tested before the first turn and behind each; its counter never passes 64 bits."""
        first, last = self._operand(s.first), self._operand(s.last)
        body, turn, end, begun = self._label(), self._label(), self._label(), self.block
        counters = self._written_out(s)
        if counters is not None:
            self._turns(s, counters, end)
            return
        loop, below = self._loop(s, turn, end), "slt" if s.step > 0 else "sgt"
        any_turn, next_counter, more = self._fresh(), self._fresh(), self._fresh()
        self.lines.append(f"{any_turn} = icmp {below} i64 {first}, {last}")
        self._branch(any_turn, body, end)
        self._begin(body)
        counter = self._named(s.counter)
        self.lines.append(f"{counter} = phi i64 [ {first}, %{begun} ], [ {next_counter}, %{turn} ]")
        self._turn(loop, s.body, counter)
        self._counted(s, counter, next_counter, last, more)
        self._branch(self._and_any(more, loop), body, end, self._kept_short())
        self._begin(end)

    def _counted(self, s: form.For, counter: str, next_counter: str, last: str, more: str) -> None:
        """Write the next counter of a loop, and whether it has another turn."""
        if cannot_overflow(s):
            self.lines.append(f"{next_counter} = add nsw i64 {counter}, {s.step}")
            self.lines.append(f"{more} = icmp {'slt' if s.step > 0 else 'sgt'} i64 {next_counter}, {last}")
        else:
            left, (high, low) = self._fresh(), (last, counter) if s.step > 0 else (counter, last)
            self.lines.append(f"{next_counter} = add i64 {counter}, {s.step}")
            self.lines.append(f"{left} = sub i64 {high}, {low}")
            self.lines.append(f"{more} = icmp ugt i64 {left}, {abs(s.step)}")

    def _kept_short(self) -> str:
        """Return the mark of a loop in a solver: its body is not worth a copy for each turn."""
        if self.is_entry or self.function.inline:
            return ""
        self._need((_SHORT,))
        return ", !llvm.loop !1"

    def _turns(self, s: form.For, counters: range, end: str) -> None:
        """The turns of a loop, written one behind the other."""
        for number in counters:
            loop = self._loop(s, self._label(), end)
            self.names[s.counter] = str(number)
            self._turn(loop, s.body, str(number))
        self._jump(end)
        self._begin(end)

    def _written_out(self, s: form.For) -> range | None:
        return written_out(s)

    def _loop(self, s: form.For | form.While, turn: str, end: str) -> LoopLabels:
        """A loop that is about to begin."""
        return LoopLabels(turn, end)

    def _turn(self, loop: LoopLabels, body: form.Region, counter: str) -> None:
        """A turn of a loop, up to where the next one is decided on."""
        self.loops.append(loop)
        self._long_region(body, counter)
        self.loops.pop()
        self._jump(loop.turn)
        self._begin(loop.turn)

    def _and_any(self, more: str, loop: LoopLabels) -> str:
        """Return whether a loop has another turn, where its counter has."""
        return more

    def _long_region(self, region: form.Region, integer: str) -> None:
        """A region in blocks of instructions that LLVM cannot join: it is slow on very long ones.

        From one to the next there are two ways, and on that for one value of an integer an empty
        instruction.
        """
        for place in range(0, len(region), _LONGEST):
            self.region(region[place : place + _LONGEST])
            if place + _LONGEST < len(region) and self.block:
                self._part(integer, place)

    def _part(self, counter: str, place: int) -> None:
        rare, following, is_rare = self._label(), self._label(), self._fresh()
        self.lines.append(f"{is_rare} = icmp eq i64 {counter}, {-1 - place}")
        self._branch(is_rare, rare, following)
        self._begin(rare)
        self.lines.append('call void asm sideeffect "", ""() #4')
        self._jump(following)
        self._begin(following)

    def _while(self, s: form.While) -> None:
        test, body, end = self._label(), self._label(), self._label()
        self._jump(test)
        self._begin(test)
        self.region(s.test)  # which never jumps
        self._branch(self._operand(s.condition), body, end)
        self._begin(body)
        self.loops.append(LoopLabels(test, end))
        self.region(s.body)
        self.loops.pop()
        self._jump(test)
        self._begin(end)

    def _break(self, _: form.Break) -> None:
        self._jump(self.loops[-1].end)

    def _continue(self, _: form.Continue) -> None:
        self._jump(self.loops[-1].turn)

    def _return(self, s: form.Return) -> None:
        self._give([self._typed(value) for value in s.values], result_type(self.function.results))

    def _give(self, values: list[str], kind: str) -> None:
        """Return these values with their types, together of a kind."""
        if len(values) < 2:
            self.lines.append(f"ret {values[0]}" if values else "ret void")
        else:
            whole = "poison"
            for place, value in enumerate(values):
                before, whole = whole, self._fresh()
                self.lines.append(f"{whole} = insertvalue {kind} {before}, {value}, {place}")
            self.lines.append(f"ret {kind} {whole}")
        self.block = ""
