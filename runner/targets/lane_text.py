"""A program for several runs side by side, in LLVM's language: what differs between them is a vector of a lane a run.

All lanes go through the program together. Where they part, both ways are gone, each with a mask of the lanes that are
active on it: what is set or stored there is taken from these lanes alone. Arithmetic needs no mask, since no operation
can fail. Each lane computes the bits of its run alone. In memory an entry of an array is a row of all lanes.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from proofmass.runner.program.form import (
    INTEGER,
    TRUTH,
    Array,
    Break,
    Call,
    Compute,
    Constant,
    Continue,
    External,
    For,
    Function,
    Get,
    If,
    Kind,
    Load,
    Operand,
    Program,
    Region,
    Return,
    Set,
    Store,
    Value,
    View,
    While,
)
from proofmass.runner.program.varying import ArrayOf, Lanes, Varying, Way
from proofmass.runner.program.walk import statements
from proofmass.runner.targets.llvm_operations import TYPES, constant, select, splat, templates
from proofmass.runner.targets.llvm_text import (
    ATTRIBUTES,
    BYTES,
    ENTRY,
    STORED,
    FunctionText,
    cannot_overflow,
    declared,
    power_of_two,
    symbol_of,
)

_LIGHT = 12  # operations that are rather done for nothing than jumped over
_HEAVY = {"divide": 8, "square_root": 8, "floor_divide": 40, "modulo": 40}
_LINE = 64  # bytes of the widest vector


class LanesOf(NamedTuple):
    """Of the entry: numbers that differ from run to run, arrays that all share, entries of the others that differ."""

    numbers: frozenset[Value]
    shared: frozenset[Array]
    entries: Mapping[Array, int]  # as bits


def lane_text(program: Program, lanes: int, of_entry: LanesOf) -> str:
    """The module of a program for so many runs; numbers of the entry that differ are given as addresses of rows."""
    return _LaneProgram(program, lanes, of_entry).text()


class _LaneProgram:
    """Writes each function for each way in which it is called."""

    def __init__(self, program: Program, lanes: int, of_entry: LanesOf) -> None:
        self.lanes, self.looked = lanes, Lanes()
        self.entry = self.looked.of_entry(program.entry, *of_entry)
        self.beside: dict[str, None] = {}
        self.symbols: dict[tuple[Function, Way], str] = {}
        self.waiting: list[Varying] = []
        self.operations = templates(lanes)

    def text(self) -> str:
        """The module."""
        texts = [_LaneFunction(self, self.entry, ENTRY).text()]
        while self.waiting:
            varying = self.waiting.pop()
            texts.append(_LaneFunction(self, varying, self.symbols[varying.function, varying.way]).text())
        return "\n".join([*self.beside, *texts, *ATTRIBUTES, ""])

    def called(self, function: Function, way: Way) -> tuple[str, Varying]:
        """Symbol of a function that is called in a way, and what differs in it."""
        varying = self.looked.of(function, way)
        if (function, way) not in self.symbols:
            self.symbols[function, way] = f"f.{function.name}.{len(self.symbols)}"
            self.waiting.append(varying)
        return self.symbols[function, way], varying


class _Loop(NamedTuple):
    """Where Continue and Break go; in a loop that lanes leave apart, places of the masks of those that are in it."""

    turn: str
    end: str
    base: str  # mask of all lanes of the turn
    live: str = ""  # place of the lanes that will take the next turn
    active: str = ""  # place of the lanes that have not left this turn


class _LaneFunction(FunctionText):
    """One function, called in one way. A mask is the name of a vector, or "" where all lanes are active."""

    def __init__(self, program: _LaneProgram, varying: Varying, symbol: str) -> None:
        super().__init__(varying.function, symbol == ENTRY, program.beside)
        self.program, self.varying, self.symbol, self.lanes = program, varying, symbol, program.lanes
        self.base = self.mask = "%mask" if varying.way.masked else ""
        self.top: list[str] = []  # what stands before all other lines
        self.levels: list[_Loop] = []
        self.offsets: dict[Array, str] = {}  # vectors of where arrays begin
        self.alive = self._slot(TRUTH, self.base) if varying.parting else ""
        self.sink = ""

    def text(self) -> str:
        """Definition of the function."""
        function, varying = self.function, self.varying
        parameters = [f"{self._vector(TRUTH)} %mask"] if varying.way.masked else []
        for parameter, way in zip(function.parameters, varying.way.parameters, strict=True):
            parameters += self._lane_parameters(parameter, way)
        self.slots = [self._slot(kind, "", True) for kind in function.results] if varying.parting else []
        for variable in function.variables:
            kind, differs = variable.kind, variable in varying.numbers
            of, place = self._type(kind, differs), self._named(variable)
            self.top += [f"{place} = alloca {of}", f"store {of} zeroinitializer, ptr {place}"]
        self.region(function.body)
        if self.block:
            self._end()
        how = "" if self.is_entry else "internal fastcc "
        attributes = "#1" if function.inline and not self.is_entry else "#0"
        head = f"define {how}{self._returned(varying)} @{self.symbol}({', '.join(parameters)}) {attributes} {{"
        return "\n".join([head, "entry:", *self.top, *self.lines, "}"])

    def _lane_parameters(self, parameter: Value | Array, way: bool | ArrayOf) -> list[str]:
        if isinstance(parameter, Value):
            name = self._named(parameter)
            if self.is_entry and way:
                row, kind = self._fresh(), parameter.kind
                self.top.append(f"{name} = load {self._vector(kind)}, ptr {row}, align {self._alignment(kind)}")
                return [f"ptr noalias readonly {row}"]
            return [f"{self._type(parameter.kind, bool(way))} {name}"]
        assert isinstance(way, ArrayOf)
        lanes = self.lanes if way.rows else 1
        size = (parameter.length or 0) * BYTES[parameter.entry] * lanes
        facts = ("noalias " if self.is_entry else "") + ("" if parameter.writable else "readonly ")
        facts += f"dereferenceable({size}) " if size else ""
        align = self._alignment(parameter.entry) if way.rows else BYTES[parameter.entry]
        texts = [f"ptr {facts}nonnull align {align} {self._named(parameter)}"]
        if way.apart:
            self.offsets[parameter] = self._fresh()
            texts.append(f"{self._vector(INTEGER)} {self.offsets[parameter]}")
        return texts

    # -- types and numbers -----------------------------------------------------------------------------------------

    def _vector(self, kind: Kind) -> str:
        return f"<{self.lanes} x {TYPES[kind]}>"

    def _type(self, kind: Kind, differs: bool) -> str:
        return self._vector(kind) if differs else TYPES[kind]

    def _alignment(self, kind: Kind) -> int:
        return min(_LINE, self.lanes * BYTES[kind])

    def _returned(self, varying: Varying) -> str:
        kinds = [self._type(k, differs) for k, differs in zip(varying.function.results, varying.results, strict=True)]
        if not kinds:
            return "void"
        return kinds[0] if len(kinds) == 1 else f"{{ {', '.join(kinds)} }}"

    def _all(self, operand: Operand) -> str:
        """A number of every lane as a vector."""
        if isinstance(operand, Constant):
            return splat(operand.kind, constant(operand), self.lanes)
        name = self.names[operand]
        return name if operand in self.varying.numbers else self._spread(operand.kind, name)

    def _spread(self, kind: Kind, name: str) -> str:
        one, every, of = self._fresh(), self._fresh(), self._vector(kind)
        self.lines.append(f"{one} = insertelement {of} poison, {TYPES[kind]} {name}, i64 0")
        self.lines.append(f"{every} = shufflevector {of} {one}, {of} poison, <{self.lanes} x i32> zeroinitializer")
        return every

    def _as(self, operand: Operand, differs: bool) -> str:
        """A number with its type, as a vector or not."""
        return f"{self._type(operand.kind, differs)} {self._all(operand) if differs else self._operand(operand)}"

    # -- masks -----------------------------------------------------------------------------------------------------

    def _slot(self, kind: Kind, first: str, zero: bool = False) -> str:
        """A place on the stack for a vector; it begins with `first`, or with lanes that are all true, or zero."""
        place, of = self._fresh(), self._vector(kind)
        value = "zeroinitializer" if zero else first or splat(TRUTH, "true", self.lanes)
        self.top += [f"{place} = alloca {of}", f"store {of} {value}, ptr {place}"]
        return place

    def _write(self, place: str, mask: str) -> None:
        of = self._vector(TRUTH)
        self.lines.append(f"store {of} {mask or splat(TRUTH, 'true', self.lanes)}, ptr {place}")

    def _read(self, place: str, kind: Kind = TRUTH) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = load {self._vector(kind)}, ptr {place}")
        return name

    def _both(self, mask: str, other: str) -> str:
        if not mask:
            return other
        name = self._fresh()
        self.lines.append(f"{name} = and {self._vector(TRUTH)} {mask}, {other}")
        return name

    def _not(self, mask: str) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = xor {self._vector(TRUTH)} {mask}, {splat(TRUTH, 'true', self.lanes)}")
        return name

    def _any(self, mask: str) -> str:
        """Whether any lane is active."""
        bits, any_lane = self._fresh(), self._fresh()
        self.lines.append(f"{bits} = bitcast {self._vector(TRUTH)} {mask} to i{self.lanes}")
        self.lines.append(f"{any_lane} = icmp ne i{self.lanes} {bits}, 0")
        return any_lane

    def _blend(self, kind: Kind, mask: str, new: str, old: str) -> str:
        if not mask:
            return new
        name, of = self._fresh(), self._vector(kind)
        self.lines.append(f"{name} = select {self._vector(TRUTH)} {mask}, {of} {new}, {of} {old}")
        return name

    def _without(self, place: str, mask: str) -> None:
        """Take lanes out of a mask in its place."""
        self._write(place, self._both(self._read(place), self._not(mask)))

    # -- statements ------------------------------------------------------------------------------------------------

    def region(self, region: Region) -> None:
        """Statements; behind one where lanes part, with those that are left."""
        outer = self.mask
        for statement in region:
            if not self.block:
                break
            _WRITERS[type(statement)](self, statement)
            if id(statement) in self.varying.parting and self.block:
                place = self.levels[-1].active if self.levels else self.alive
                if place:
                    self.mask = self._both(outer, self._read(place))
        self.mask = outer

    def compute(self, s: Compute) -> None:
        """Compute."""
        if s.result not in self.varying.numbers:
            super().compute(s)
            return
        if s.operation == "select":
            apart = self.varying.differs(s.operands[0])
            read = [self._all(s.operands[0]) if apart else self._operand(s.operands[0])]
            read += map(self._all, s.operands[1:])
            text = select(s.result.kind, self.lanes, self.lanes if apart else 0)
        elif s.operation in ("floor_divide", "modulo") and (shift := power_of_two(s.operands[1])) is not None:
            down = s.operation == "floor_divide"
            by = splat(INTEGER, str(shift if down else (1 << shift) - 1), self.lanes)
            text, read = (
                f"%s = {'ashr' if down else 'and'} {self._vector(INTEGER)} %s, %s",
                [self._all(s.operands[0]), by],
            )
        else:
            read = [self._all(operand) for operand in s.operands]
            text, needs = self.program.operations[s.operation]
            self._need(needs)
        self.lines.append(text % (self._named(s.result), *read))

    def get(self, s: Get) -> None:
        """Get."""
        of = self._type(s.result.kind, s.variable in self.varying.numbers)
        self.lines.append(f"{self._named(s.result)} = load {of}, ptr {self.names[s.variable]}")

    def set(self, s: Set) -> None:
        """Set."""
        if s.variable not in self.varying.numbers:
            super().set(s)
            return
        place, kind, new = self.names[s.variable], s.variable.kind, self._all(s.value)
        if self.mask != self.base:
            new = self._blend(kind, self.mask, new, self._read(place, kind))
        self.lines.append(f"store {self._vector(kind)} {new}, ptr {place}")

    # -- arrays ----------------------------------------------------------------------------------------------------

    def _row(self, array: Array, index: Operand) -> str:
        """The address of an entry that is the same one in all lanes, or of its row."""
        lanes = self.lanes if self.varying.given(array).rows else 1
        base, place = self.names[array], self._fresh()
        if isinstance(index, Constant):
            at = str(int(index.value) * lanes)
        elif lanes == 1:
            at = self.names[index]
        else:
            at = self._fresh()
            self.lines.append(f"{at} = mul nsw i64 {self.names[index]}, {lanes}")
        self.lines.append(f"{place} = getelementptr inbounds {STORED[array.entry]}, ptr {base}, i64 {at}")
        return place

    def _is_apart(self, array: Array, index: Operand) -> bool:
        return array in self.offsets or self.varying.differs(index)

    def _places(self, array: Array, index: Operand) -> list[str]:
        """Addresses of entries, another one in each lane; an inactive lane has that of the first entry."""
        of, at = self._vector(INTEGER), self._all(index)
        if array in self.offsets:
            at = self._sum(at, self.offsets[array])
        if self.mask:
            at = self._blend(INTEGER, self.mask, at, "zeroinitializer")
        if self.varying.given(array).rows:
            by, lane = self._fresh(), f"<{', '.join(f'i64 {lane}' for lane in range(self.lanes))}>"
            self.lines.append(f"{by} = mul nsw {of} {at}, {splat(INTEGER, str(self.lanes), self.lanes)}")
            at = self._sum(by, lane)
        places = []
        for lane_number in range(self.lanes):
            one, place = self._lane(INTEGER, at, lane_number), self._fresh()
            entry = STORED[array.entry]
            self.lines.append(f"{place} = getelementptr inbounds {entry}, ptr {self.names[array]}, i64 {one}")
            places.append(place)
        return places

    def _sum(self, one: str, other: str) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = add nsw {self._vector(INTEGER)} {one}, {other}")
        return name

    def _lane(self, kind: Kind, vector: str, lane: int) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = extractelement {self._vector(kind)} {vector}, i64 {lane}")
        return name

    def _put(self, kind: Kind, vector: str, value: str, lane: int) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = insertelement {self._vector(kind)} {vector}, {TYPES[kind]} {value}, i64 {lane}")
        return name

    def load(self, s: Load) -> None:
        """Load."""
        kind = s.array.entry
        if self._is_apart(s.array, s.index):
            whole = "poison"
            for lane, place in enumerate(self._places(s.array, s.index)):
                whole = self._put(kind, whole, self._read_entry(kind, place, 0), lane)
            self.names[s.result] = whole
        else:
            differs = s.result in self.varying.numbers
            self.names[s.result] = self._read_entry(kind, self._row(s.array, s.index), self.lanes if differs else 0)

    def _read_entry(self, kind: Kind, place: str, lanes: int) -> str:
        """An entry, or the row of so many lanes."""
        stored, name = f"<{lanes} x {STORED[kind]}>" if lanes else STORED[kind], self._fresh()
        align = self._alignment(kind) if lanes else BYTES[kind]
        self.lines.append(f"{name} = load {stored}, ptr {place}, align {align}")
        if kind is not TRUTH:
            return name
        truth = self._fresh()
        self.lines.append(f"{truth} = icmp ne {stored} {name}, zeroinitializer")
        return truth

    def _write_entry(self, kind: Kind, place: str, value: str, lanes: int) -> None:
        stored = f"<{lanes} x {STORED[kind]}>" if lanes else STORED[kind]
        align = self._alignment(kind) if lanes else BYTES[kind]
        if kind is TRUTH:
            of, byte = f"<{lanes} x i1>" if lanes else "i1", self._fresh()
            self.lines.append(f"{byte} = zext {of} {value} to {stored}")
            value = byte
        self.lines.append(f"store {stored} {value}, ptr {place}, align {align}")

    def store(self, s: Store) -> None:
        """Store."""
        kind, new = s.array.entry, self._all(s.value)
        assert self.varying.given(s.array).rows, f"{s.array.name} is shared by all lanes"
        if not self._is_apart(s.array, s.index):
            place = self._row(s.array, s.index)
            if self.mask:
                new = self._blend(kind, self.mask, new, self._read_entry(kind, place, self.lanes))
            self._write_entry(kind, place, new, self.lanes)
            return
        for lane, place in enumerate(self._places(s.array, s.index)):
            self._write_entry(kind, self._if_active(place, lane), self._lane(kind, new, lane), 0)

    def _if_active(self, place: str, lane: int) -> str:
        """The address, or one that nobody reads where the lane is inactive."""
        if not self.mask:
            return place
        if not self.sink:
            self.sink = self._fresh()
            self.top.append(f"{self.sink} = alloca i64")
        chosen, active = self._fresh(), self._lane(TRUTH, self.mask, lane)
        self.lines.append(f"{chosen} = select i1 {active}, ptr {place}, ptr {self.sink}")
        return chosen

    def view(self, s: View) -> None:
        """View."""
        if not self.varying.differs(s.first):
            self.names[s.part] = self._row(s.whole, s.first)
            if s.whole in self.offsets:
                self.offsets[s.part] = self.offsets[s.whole]
            return
        self.names[s.part], at = self.names[s.whole], self._all(s.first)
        self.offsets[s.part] = self._sum(at, self.offsets[s.whole]) if s.whole in self.offsets else at

    # -- calls -----------------------------------------------------------------------------------------------------

    def call(self, s: Call) -> None:
        """Call."""
        if isinstance(s.function, External):
            self._external(s, s.function)
            return
        symbol, inside = self.program.called(s.function, self.varying.calls[id(s)])
        read = [f"{self._vector(TRUTH)} {self.mask or splat(TRUTH, 'true', self.lanes)}"] if inside.way.masked else []
        for argument, way in zip(s.arguments, inside.way.parameters, strict=True):
            if isinstance(argument, Array):
                read.append(f"ptr {self.names[argument]}")
                read += [f"{self._vector(INTEGER)} {self.offsets[argument]}"] if argument in self.offsets else []
            else:
                read.append(self._as(argument, bool(way)))
        returned = self._returned(inside)
        call = f"call fastcc {returned} @{symbol}({', '.join(read)})"
        if not s.results:
            self.lines.append(call)
            return
        whole = self._fresh()
        self.lines.append(f"{whole} = {call}")
        for place, (result, differs) in enumerate(zip(s.results, inside.results, strict=True)):
            part = whole
            if len(s.results) > 1:
                part = self._fresh()
                self.lines.append(f"{part} = extractvalue {returned} {whole}, {place}")
            spread = result in self.varying.numbers and not differs
            self.names[result] = self._spread(result.kind, part) if spread else part

    def _external(self, s: Call, function: External) -> None:
        if function.pure and not any(self.varying.differs(a) for a in s.arguments if not isinstance(a, Array)):
            super().call(s)
            return
        self._need((declared(function),))
        read = [(a.kind, self._all(a)) for a in s.arguments if not isinstance(a, Array)]
        whole = self._slot(function.result, "", True) if function.result else ""
        for lane in range(self.lanes):
            apart = bool(self.mask) and not function.pure
            active, end = self._label(), self._label()
            if apart:
                self._branch(self._lane(TRUTH, self.mask, lane), active, end)
                self._begin(active)
            arguments = ", ".join(f"{TYPES[kind]} {self._lane(kind, name, lane)}" for kind, name in read)
            returned = TYPES[function.result] if function.result else "void"
            call = f"call {returned} @{symbol_of(function)}({arguments})"
            if function.result:
                one = self._fresh()
                self.lines.append(f"{one} = {call}")
                put = self._put(function.result, self._read(whole, function.result), one, lane)
                self.lines.append(f"store {self._vector(function.result)} {put}, ptr {whole}")
            else:
                self.lines.append(call)
            if apart:
                self._jump(end)
                self._begin(end)
        if function.result:
            self.names[s.results[0]] = self._read(whole, function.result)

    # -- ways that part --------------------------------------------------------------------------------------------

    def if_(self, s: If) -> None:
        """If."""
        if not self.varying.differs(s.condition):
            super().if_(s)
            return
        outer, condition = self.mask, self._all(s.condition)
        masks = (self._both(outer, condition), self._both(outer, self._not(condition)) if s.otherwise else "")
        for region, mask in zip((s.then, s.otherwise), masks, strict=True):
            if region:
                self.mask = mask
                self._where_any(region)
        self.mask = outer

    def _where_any(self, region: Region) -> None:
        """A region with the lanes of the mask, jumped over where there is none and that is worth it."""
        if _weight(region) <= _LIGHT:
            self.region(region)
            return
        some, end = self._label(), self._label()
        self._branch(self._any(self.mask), some, end)
        self._begin(some)
        self.region(region)
        self._jump(end)
        self._begin(end)

    def _loop(self, s: For | While, turn: str, end: str) -> _Loop:
        """A loop that is about to begin."""
        if id(s) not in self.varying.loops:
            return _Loop(turn, end, self.mask)
        live, active = self._slot(TRUTH, "", True), self._slot(TRUTH, "", True)
        self._write(live, self.mask)
        return _Loop(turn, end, "", live, active)

    def _turn(self, loop: _Loop, body: Region) -> None:
        """A turn of a loop, up to where the next one is decided on."""
        outer = self.mask
        if loop.live:
            self.mask = self._read(loop.live)
            self._write(loop.active, self.mask)
            loop = loop._replace(base=self.mask)
        self.levels.append(loop)
        self.region(body)
        self.levels.pop()
        self._jump(loop.turn)
        self._begin(loop.turn)
        self.mask = outer

    def for_(self, s: For) -> None:
        """For."""
        if self.varying.differs(s.counter):
            self._counted_apart(s)
            return
        first, last = self._operand(s.first), self._operand(s.last)
        body, turn, end, begun = self._label(), self._label(), self._label(), self.block
        loop, below = self._loop(s, turn, end), "slt" if s.step > 0 else "sgt"
        any_turn, next_counter, more = self._fresh(), self._fresh(), self._fresh()
        self.lines.append(f"{any_turn} = icmp {below} i64 {first}, {last}")
        self._branch(any_turn, body, end)
        self._begin(body)
        counter = self._named(s.counter)
        self.lines.append(f"{counter} = phi i64 [ {first}, %{begun} ], [ {next_counter}, %{turn} ]")
        self._turn(loop, s.body)
        if cannot_overflow(s):
            self.lines.append(f"{next_counter} = add nsw i64 {counter}, {s.step}")
            self.lines.append(f"{more} = icmp {below} i64 {next_counter}, {last}")
        else:
            left, (high, low) = self._fresh(), (last, counter) if s.step > 0 else (counter, last)
            self.lines.append(f"{next_counter} = add i64 {counter}, {s.step}")
            self.lines.append(f"{left} = sub i64 {high}, {low}")
            self.lines.append(f"{more} = icmp ugt i64 {left}, {abs(s.step)}")
        self._branch(self._and_any(more, loop), body, end)
        self._begin(end)

    def _and_any(self, more: str, loop: _Loop) -> str:
        if not loop.live:
            return more
        any_lane, both = self._any(self._read(loop.live)), self._fresh()
        self.lines.append(f"{both} = and i1 {more}, {any_lane}")
        return both

    def _counted_apart(self, s: For) -> None:
        """A loop whose counter differs from lane to lane."""
        of, below = self._vector(INTEGER), "slt" if s.step > 0 else "sgt"
        first, last, place = self._all(s.first), self._all(s.last), self._slot(INTEGER, "", True)
        body, turn, end = self._label(), self._label(), self._label()
        loop, some = self._loop(s, turn, end), self._fresh()
        self.lines.append(f"store {of} {first}, ptr {place}")
        self.lines.append(f"{some} = icmp {below} {of} {first}, {last}")
        self._go_on(loop, some, body)
        self._begin(body)
        self.names[s.counter] = counter = self._read(place, INTEGER)
        self._turn(loop, s.body)
        left, more, (high, low) = self._fresh(), self._fresh(), (last, counter) if s.step > 0 else (counter, last)
        self.lines.append(f"{left} = sub {of} {high}, {low}")
        self.lines.append(f"{more} = icmp ugt {of} {left}, {splat(INTEGER, str(abs(s.step)), self.lanes)}")
        next_counter = self._fresh()
        self.lines.append(f"{next_counter} = add {of} {counter}, {splat(INTEGER, str(s.step), self.lanes)}")
        self.lines.append(f"store {of} {next_counter}, ptr {place}")
        self._go_on(loop, more, body)
        self._begin(end)

    def _go_on(self, loop: _Loop, lanes: str, body: str) -> None:
        """Into the body with those of its lanes that are among `lanes`, or to the end."""
        live = self._both(self._read(loop.live), lanes)
        self._write(loop.live, live)
        self._branch(self._any(live), body, loop.end)

    def while_(self, s: While) -> None:
        """While."""
        test, body, end = self._label(), self._label(), self._label()
        loop, outer = self._loop(s, test, end), self.mask
        self._jump(test)
        self._begin(test)
        if loop.live:
            self.mask = self._read(loop.live)
        self.region(s.test)
        self.mask = outer
        if self.varying.differs(s.condition):
            self._go_on(loop, self._all(s.condition), body)
        else:
            self._branch(self._and_any(self._operand(s.condition), loop), body, end)
        self._begin(body)
        again = self._label()
        self._turn(loop._replace(turn=again), s.body)
        self._jump(test)
        self._begin(end)

    def break_(self, _: Break) -> None:
        """Break."""
        loop = self.levels[-1]
        if self.mask == loop.base:
            self._jump(loop.end)
        else:
            self._without(loop.live, self.mask)
            self._without(loop.active, self.mask)

    def continue_(self, _: Continue) -> None:
        """Continue."""
        loop = self.levels[-1]
        if self.mask == loop.base:
            self._jump(loop.turn)
        else:
            self._without(loop.active, self.mask)

    def return_(self, s: Return) -> None:
        """Return."""
        if self.mask == self.base:
            self._give([self._as(v, d) for v, d in zip(s.values, self.varying.results, strict=True)])
            return
        for value, place in zip(s.values, self.slots, strict=True):
            new = self._blend(value.kind, self.mask, self._all(value), self._read(place, value.kind))
            self.lines.append(f"store {self._vector(value.kind)} {new}, ptr {place}")
        for loop in self.levels:
            self._without(loop.live, self.mask)
            self._without(loop.active, self.mask)
        self._without(self.alive, self.mask)

    def _end(self) -> None:
        """The end of the body: lanes that returned apart are all there."""
        if not self.slots:
            self.lines.append("unreachable" if self.function.results else "ret void")
            return
        kinds = self.function.results
        self._give([f"{self._vector(k)} {self._read(place, k)}" for k, place in zip(kinds, self.slots, strict=True)])

    def _give(self, values: list[str]) -> None:
        if not values:
            self.lines.append("ret void")
        elif len(values) == 1:
            self.lines.append(f"ret {values[0]}")
        else:
            whole = "poison"
            for place, value in enumerate(values):
                before, whole = whole, self._fresh()
                self.lines.append(f"{whole} = insertvalue {self._returned(self.varying)} {before}, {value}, {place}")
            self.lines.append(f"ret {self._returned(self.varying)} {whole}")
        self.block = ""


def _weight(region: Region) -> int:
    """About how many operations a region takes."""
    weight = 0
    for s in statements(region):
        if isinstance(s, Compute):
            weight += _HEAVY.get(s.operation, 1)
        elif isinstance(s, For | While):
            weight += 4 * _LIGHT
        elif isinstance(s, Call):
            weight += _LIGHT if isinstance(s.function, External) else _weight(s.function.body)
        else:
            weight += 1
    return weight


_WRITERS: dict[type, Any] = {
    Compute: _LaneFunction.compute, Get: _LaneFunction.get, Set: _LaneFunction.set, Load: _LaneFunction.load,
    Store: _LaneFunction.store, View: _LaneFunction.view, Call: _LaneFunction.call, If: _LaneFunction.if_,
    For: _LaneFunction.for_, While: _LaneFunction.while_, Break: _LaneFunction.break_,
    Continue: _LaneFunction.continue_, Return: _LaneFunction.return_,
}  # fmt: skip
