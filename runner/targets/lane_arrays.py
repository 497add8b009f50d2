"""Entries of arrays for runs side by side: rows of all lanes, or another entry in each lane."""

from proofmass.runner.program.form import INTEGER, TRUTH, Immediate, Kind, Load, Operand, Storage, Store, View
from proofmass.runner.targets.lane_vectors import LaneVectors
from proofmass.runner.targets.llvm_operations import splat
from proofmass.runner.targets.llvm_text import BYTES, STORED


class LaneArrays(LaneVectors):
    """A function whose loads and stores are written for lanes."""

    def _row(self, array: Storage, index: Operand) -> str:
        """The address of an entry that is the same one in all lanes, or of its row."""
        lanes = self.lanes if self.varying.given(array).rows else 1
        base, place = self.names[array], self._fresh()
        if isinstance(index, Immediate):
            at = str(int(index.value) * lanes)
        elif lanes == 1:
            at = self.names[index]
        else:
            at = self._fresh()
            self.lines.append(f"{at} = mul nsw i64 {self.names[index]}, {lanes}")
        self.lines.append(f"{place} = getelementptr inbounds {STORED[array.entry]}, ptr {base}, i64 {at}")
        return place

    def _is_apart(self, array: Storage, index: Operand) -> bool:
        return array in self.offsets or self.varying.differs(index)

    def _places(self, array: Storage, index: Operand) -> list[str]:
        """Addresses of entries, another one in each lane; inactive lanes have the first one's."""
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

    def _load(self, s: Load) -> None:
        kind = s.array.entry
        if self._is_apart(s.array, s.at):
            whole = "poison"
            for lane, place in enumerate(self._places(s.array, s.at)):
                whole = self._put(kind, whole, self._read_entry(kind, place, 0), lane)
            self.names[s.result] = whole
        else:
            differs = s.result in self.varying.numbers
            self.names[s.result] = self._read_entry(kind, self._row(s.array, s.at), self.lanes if differs else 0)

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

    def _store(self, s: Store) -> None:
        kind = s.array.entry
        if not self.varying.given(s.array).rows:
            alike = not (self.mask or self._is_apart(s.array, s.at) or self.varying.differs(s.value))
            assert alike, f"{s.array.name} is shared by all lanes"
            self._write_entry(kind, self._row(s.array, s.at), self._operand(s.value), 0)
            return
        new = self._all(s.value)
        if not self._is_apart(s.array, s.at):
            place = self._row(s.array, s.at)
            if self.mask:
                new = self._blend(kind, self.mask, new, self._read_entry(kind, place, self.lanes))
            self._write_entry(kind, place, new, self.lanes)
            return
        for lane, place in enumerate(self._places(s.array, s.at)):
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

    def _view(self, s: View) -> None:
        if not self.varying.differs(s.first):
            self.names[s.part] = self._row(s.whole, s.first)
            if s.whole in self.offsets:
                self.offsets[s.part] = self.offsets[s.whole]
            return
        self.names[s.part], at = self.names[s.whole], self._all(s.first)
        self.offsets[s.part] = self._sum(at, self.offsets[s.whole]) if s.whole in self.offsets else at
