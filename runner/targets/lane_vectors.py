"""Vectors and masks of a function for runs side by side: the instructions that all its statements are made of."""

from proofmass.runner.program.form import TRUTH, Immediate, Kind, Operand, Storage
from proofmass.runner.program.varying import Varying
from proofmass.runner.targets.llvm_operations import TYPES, constant, splat
from proofmass.runner.targets.llvm_text import BYTES, FunctionText

_LINE = 64  # bytes of the widest vector


class LaneVectors(FunctionText):
    """A function that is written for lanes. A mask is the name of a vector, or "" where all lanes are active."""

    def __init__(self, varying: Varying, lanes: int, is_entry: bool, beside: dict[str, None]) -> None:
        super().__init__(varying.function, is_entry, beside)
        self.varying, self.lanes = varying, lanes
        self.base = self.mask = "%mask" if varying.way.masked else ""
        self.top: list[str] = []  # what stands before all other lines
        self.offsets: dict[Storage, str] = {}  # vectors of where arrays begin
        self.sink = ""  # a place that nobody reads

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
        if isinstance(operand, Immediate):
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
        """Return whether any lane is active."""
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

    def _lane(self, kind: Kind, vector: str, lane: int) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = extractelement {self._vector(kind)} {vector}, i64 {lane}")
        return name

    def _put(self, kind: Kind, vector: str, value: str, lane: int) -> str:
        name = self._fresh()
        self.lines.append(f"{name} = insertelement {self._vector(kind)} {vector}, {TYPES[kind]} {value}, i64 {lane}")
        return name
