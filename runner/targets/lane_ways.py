"""Ways that part, for runs side by side: both are gone, each with a mask of the lanes that are active on it."""

from proofmass.runner.program.form import (
    INTEGER,
    TRUTH,
    Break,
    Call,
    Compute,
    Continue,
    External,
    For,
    If,
    Region,
    While,
)
from proofmass.runner.program.walk import statements
from proofmass.runner.targets.lane_arrays import LaneArrays
from proofmass.runner.targets.llvm_operations import splat
from proofmass.runner.targets.llvm_text import LoopLabels

_LIGHT = 12  # so few operations are done in vain rather than jumped over
_HEAVY = {"divide": 8, "square_root": 8, "floor_divide": 40, "modulo": 40}


class LaneWays(LaneArrays):
    """A function whose branches and loops are written for lanes."""

    def _if(self, s: If) -> None:
        if not self.varying.differs(s.condition):
            super()._if(s)
            return
        outer, condition = self.mask, self._all(s.condition)
        masks = (self._both(outer, condition), self._both(outer, self._not(condition)) if s.otherwise else "")
        for region, mask in zip((s.then, s.otherwise), masks, strict=True):
            if region:
                self.mask = mask
                self._where_any(region)
        self.mask = outer

    def _where_any(self, region: Region) -> None:
        """A region with the lanes of the mask, jumped over if there is none and it pays."""
        if _weight(region) <= _LIGHT:
            self.region(region)
            return
        some, end = self._label(), self._label()
        self._branch(self._any(self.mask), some, end)
        self._begin(some)
        self.region(region)
        self._jump(end)
        self._begin(end)

    def _loop(self, s: For | While, turn: str, end: str) -> LoopLabels:
        """A loop that is about to begin."""
        if id(s) not in self.varying.loops:
            return LoopLabels(turn, end, self.mask)
        live, active = self._slot(TRUTH, "", True), self._slot(TRUTH, "", True)
        self._write(live, self.mask)
        return LoopLabels(turn, end, "", live, active)

    def _turn(self, loop: LoopLabels, body: Region, counter: str) -> None:
        """A turn of a loop, up to where the next one is decided on."""
        outer = self.mask
        if loop.live:
            self.mask = self._read(loop.live)
            self._write(loop.active, self.mask)
            loop = loop._replace(base=self.mask)
        super()._turn(loop, body, counter)
        self.mask = outer

    def _for(self, s: For) -> None:
        if self.varying.differs(s.counter):
            self._counted_apart(s)
        else:
            super()._for(s)

    def _written_out(self, s: For) -> range | None:
        return None if id(s) in self.varying.loops else super()._written_out(s)

    def _kept_short(self) -> str:
        return ""

    def _long_region(self, region: Region, integer: str) -> None:
        self.region(region)

    def _and_any(self, more: str, loop: LoopLabels) -> str:
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
        self._turn(loop, s.body, counter)
        left, more, (high, low) = self._fresh(), self._fresh(), (last, counter) if s.step > 0 else (counter, last)
        self.lines.append(f"{left} = sub {of} {high}, {low}")
        self.lines.append(f"{more} = icmp ugt {of} {left}, {splat(INTEGER, str(abs(s.step)), self.lanes)}")
        next_counter = self._fresh()
        self.lines.append(f"{next_counter} = add {of} {counter}, {splat(INTEGER, str(s.step), self.lanes)}")
        self.lines.append(f"store {of} {next_counter}, ptr {place}")
        self._go_on(loop, more, body)
        self._begin(end)

    def _go_on(self, loop: LoopLabels, lanes: str, body: str) -> None:
        """Into the body with those of its lanes that are among `lanes`, or to the end."""
        live = self._both(self._read(loop.live), lanes)
        self._write(loop.live, live)
        self._branch(self._any(live), body, loop.end)

    def _while(self, s: While) -> None:
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
        self._turn(loop._replace(turn=again), s.body, "")
        self._jump(test)
        self._begin(end)

    def _break(self, _: Break) -> None:
        loop = self.loops[-1]
        if self.mask == loop.base:
            self._jump(loop.end)
        else:
            self._without(loop.live, self.mask)
            self._without(loop.active, self.mask)

    def _continue(self, _: Continue) -> None:
        loop = self.loops[-1]
        if self.mask == loop.base:
            self._jump(loop.turn)
        else:
            self._without(loop.active, self.mask)


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
