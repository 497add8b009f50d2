"""A program for several runs side by side, in LLVM's language: what differs between them is a
vector of a lane a run.

All lanes go through the program together. Where they part, both ways are gone, each with a mask of
the lanes that are active on it: what is set or stored there is taken from these lanes alone.
Arithmetic needs no mask, since no operation can fail. Each lane computes the bits of its run alone.
In memory an entry of an array is a row of all lanes.
"""

from collections.abc import Mapping
from typing import NamedTuple

from proofmass.runner.program import form
from proofmass.runner.program.shared import shared
from proofmass.runner.program.varying import ArrayOf, LaneAnalysis, Varying, Way
from proofmass.runner.targets.lane_ways import LaneWays
from proofmass.runner.targets.llvm_functions import ATTRIBUTES, attributes_of, declared, symbol_of
from proofmass.runner.targets.llvm_operations import TYPES, power_of_two, select, splat, templates
from proofmass.runner.targets.llvm_text import BYTES, ENTRY


class LanesOf(NamedTuple):
    """Arguments of the entry: numbers that differ by run, arrays that all share, entries of the others that differ."""

    numbers: frozenset[form.Value]
    shared: frozenset[form.Storage]
    entries: Mapping[form.Storage, int]  # as bits


def lane_text(program: form.Program, lanes: int, of_entry: LanesOf) -> str:
    """The module of a program for so many runs; numbers of the entry that differ are given as addresses of rows."""
    return _LaneProgram(program, lanes, of_entry).text()


class _LaneProgram:
    """Writes each function for each way in which it is called."""

    def __init__(self, program: form.Program, lanes: int, of_entry: LanesOf) -> None:
        self.lanes, self.looked, self.once = lanes, LaneAnalysis(), shared(program)
        self.entry = self.looked.of_entry(program.entry, *of_entry)
        self.beside: dict[str, None] = {}
        self.symbols: dict[tuple[form.Function, Way], str] = {}
        self.waiting: list[Varying] = []
        self.operations = templates(lanes)

    def text(self) -> str:
        """The module."""
        texts = [_LaneFunction(self, self.entry, ENTRY).text()]
        while self.waiting:
            varying = self.waiting.pop()
            texts.append(_LaneFunction(self, varying, self.symbols[varying.function, varying.way]).text())
        return "\n".join([*self.beside, *texts, *ATTRIBUTES, ""])

    def called(self, function: form.Function, way: Way) -> tuple[str, Varying]:
        """Symbol of a function that is called in a way, and what differs in it."""
        varying = self.looked.of(function, way)
        if (function, way) not in self.symbols:
            self.symbols[function, way] = f"f.{len(self.symbols)}"
            self.waiting.append(varying)
        return self.symbols[function, way], varying


class _LaneFunction(LaneWays):
    """One function, called in one way."""

    def __init__(self, program: _LaneProgram, varying: Varying, symbol: str) -> None:
        super().__init__(varying, program.lanes, symbol == ENTRY, program.beside)
        self.program, self.symbol = program, symbol
        self.alive = self._slot(form.TRUTH, self.base) if varying.parting else ""

    def text(self) -> str:
        """Definition of the function."""
        function, varying = self.function, self.varying
        parameters = [f"{self._vector(form.TRUTH)} %mask"] if varying.way.masked else []
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
        attributes = "#0" if self.is_entry else attributes_of(function, self.program.once)
        head = f"define {how}{self._returned(varying)} @{self.symbol}({', '.join(parameters)}) {attributes} {{"
        return "\n".join([head, "entry:", *self.top, *self.lines, "}"])

    def _lane_parameters(self, parameter: form.Value | form.Storage, way: bool | ArrayOf) -> list[str]:
        if isinstance(parameter, form.Value):
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
            texts.append(f"{self._vector(form.INTEGER)} {self.offsets[parameter]}")
        return texts

    def region(self, region: form.Region) -> None:
        """Statements; behind one where lanes part, with those that are left."""
        outer = self.mask
        for statement in region:
            if not self.block:
                break
            self._statement(statement)
            if id(statement) in self.varying.parting and self.block:
                place = self.loops[-1].active if self.loops else self.alive
                if place:
                    self.mask = self._both(outer, self._read(place))
        self.mask = outer

    def _compute(self, s: form.Compute) -> None:
        if s.result not in self.varying.numbers:
            super()._compute(s)
            return
        if s.operation == "likely":
            self.names[s.result] = self._all(s.operands[0])
            return
        if s.operation == "select":
            apart = self.varying.differs(s.operands[0])
            read = [self._all(s.operands[0]) if apart else self._operand(s.operands[0])]
            read += map(self._all, s.operands[1:])
            text = select(s.result.kind, self.lanes, self.lanes if apart else 0)
        elif s.operation in ("floor_divide", "modulo") and (shift := power_of_two(s.operands[1])) is not None:
            down = s.operation == "floor_divide"
            by = splat(form.INTEGER, str(shift if down else (1 << shift) - 1), self.lanes)
            text, read = (
                f"%s = {'ashr' if down else 'and'} {self._vector(form.INTEGER)} %s, %s",
                [self._all(s.operands[0]), by],
            )
        else:
            read = [self._all(operand) for operand in s.operands]
            text, needs = self.program.operations[s.operation]
            self._need(needs)
        self.lines.append(text % (self._named(s.result), *read))

    def _get(self, s: form.Get) -> None:
        of = self._type(s.result.kind, s.variable in self.varying.numbers)
        self.lines.append(f"{self._named(s.result)} = load {of}, ptr {self.names[s.variable]}")

    def _set(self, s: form.Set) -> None:
        if s.variable not in self.varying.numbers:
            super()._set(s)
            return
        place, kind, new = self.names[s.variable], s.variable.kind, self._all(s.value)
        if self.mask != self.base:
            new = self._blend(kind, self.mask, new, self._read(place, kind))
        self.lines.append(f"store {self._vector(kind)} {new}, ptr {place}")

    def _call(self, s: form.Call) -> None:
        if isinstance(s.function, form.External):
            self._external(s, s.function)
            return
        symbol, inside = self.program.called(s.function, self.varying.calls[id(s)])
        read = (
            [f"{self._vector(form.TRUTH)} {self.mask or splat(form.TRUTH, 'true', self.lanes)}"]
            if inside.way.masked
            else []
        )
        for argument, way in zip(s.arguments, inside.way.parameters, strict=True):
            if isinstance(argument, form.Storage):
                read.append(f"ptr {self.names[argument]}")
                read += [f"{self._vector(form.INTEGER)} {self.offsets[argument]}"] if argument in self.offsets else []
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

    def _external(self, s: form.Call, function: form.External) -> None:
        if function.pure and not any(self.varying.differs(a) for a in s.arguments if not isinstance(a, form.Storage)):
            super()._call(s)
            return
        self._need((declared(function),))
        read = [(a.kind, self._all(a)) for a in s.arguments if not isinstance(a, form.Storage)]
        whole = self._slot(function.result, "", True) if function.result else ""
        for lane in range(self.lanes):
            apart = bool(self.mask) and not function.pure
            active, end = self._label(), self._label()
            if apart:
                self._branch(self._lane(form.TRUTH, self.mask, lane), active, end)
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

    def _return(self, s: form.Return) -> None:
        if self.mask == self.base:
            values = [self._as(v, d) for v, d in zip(s.values, self.varying.results, strict=True)]
            self._give(values, self._returned(self.varying))
            return
        for value, place in zip(s.values, self.slots, strict=True):
            new = self._blend(value.kind, self.mask, self._all(value), self._read(place, value.kind))
            self.lines.append(f"store {self._vector(value.kind)} {new}, ptr {place}")
        for loop in self.loops:
            self._without(loop.live, self.mask)
            self._without(loop.active, self.mask)
        self._without(self.alive, self.mask)

    def _end(self) -> None:
        """The end of the body: lanes that returned apart are all there."""
        if not self.slots:
            self.lines.append("unreachable" if self.function.results else "ret void")
            return
        pairs = zip(self.function.results, self.slots, strict=True)
        values = [f"{self._vector(kind)} {self._read(place, kind)}" for kind, place in pairs]
        self._give(values, self._returned(self.varying))
