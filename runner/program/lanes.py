"""The loop over several runs side by side, in the lanes of vector instructions.

It is the loop of one run, arranged anew: what is the same in all runs is done once a tick; what may differ stands in
loops over the lanes, which the compiler turns into vector instructions where they are arithmetic alone. What may keep
it from that (arrays, inner loops, random numbers) stands in loops of its own, so that it does not spoil the rest.
Between these loops a variable lives in its place in memory, one lane beside the other. Every lane computes the bits of
its run alone.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.language.forms import constants_form
from proofmass.graphs.checks.schedule import Node
from proofmass.runner.plan.keys import LaneOf, LargestOf, made_up, variable, word
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.generate import Generated, LoopGenerator
from proofmass.runner.program.lane_deviates import normal_deviates
from proofmass.runner.program.pieces import FLOATS, INTEGERS, fields
from proofmass.runner.program.pieces import array as array_of
from proofmass.runner.program.statements import Statement, statements

_RUN = "run"  # the number of the run, which noise follows from


def generate_lanes(plan: Plan, varied: Collection[Node], lanes: int) -> Generated:
    """The loop of `lanes` runs that differ in noise and in the varied parameters."""
    return LaneGenerator(plan, varied, lanes).generated()


def settled_before(plan: Plan, varied: Collection[Node]) -> frozenset[str]:
    """Blocks whose varied parameters are settled before a run starts: their start or their checks use them too."""

    def settled(block: Block, parameter: str) -> bool:
        kinds = [kind for _, kind in fields(type(block).constants_class())]
        form = constants_form(type(block), compiled=True)
        once = not type(block).taken_in_the_loop(parameter) or (form is not None and bool(form.problems))
        return once or any(kind not in (float, int, bool) for kind in kinds)

    return frozenset(name for name, parameter in varied if settled(plan.blocks[name], parameter))


@dataclass
class Segment:
    """Statements that are executed together, once or for every lane."""

    guard: str
    each: bool  # lane
    straight: bool
    statements: list[Statement]

    def ignores(self, statement: Statement) -> bool:
        """Whether it does the same before and behind a statement that reads nothing of it."""
        return all(statement.writes.isdisjoint(mine.names) for mine in self.statements)

    def takes(self, other: "Segment") -> bool:
        """Whether another one behind it can be joined to it."""
        return (self.guard, self.each, self.straight) == (other.guard, other.each, other.straight)

    def exposed(self) -> set[str]:
        """Variables whose value from before the segment is read."""
        known, found = set[str](), set[str]()
        for statement in self.statements:
            found |= (statement.reads if statement.surely else statement.names) - known
            known |= statement.writes if statement.surely else set()
        return found

    def written(self) -> set[str]:
        """Variables that the segment changes."""
        return {name for statement in self.statements for name in statement.writes}


class LaneGenerator(LoopGenerator):
    """Writes the loop for several runs."""

    def __init__(self, plan: Plan, varied: Collection[Node], lanes: int) -> None:
        super().__init__(plan, lanes)
        self.varied = {name for name, _ in varied}
        self.computed = self.varied - settled_before(plan, varied)  # blocks whose constants the lanes compute
        self.deviates: dict[str, tuple[str, str]] = {}  # stream and sample of variables that are normal deviates
        self.checks: list[str] = []  # of constants that a run alone would refuse
        self.shared = {variable(node) for node in plan.recorded}  # by all lanes: nothing writes to them
        self.contexts = {f"{group.name}_context" for group in self.groups}
        self.rows = {variable(node): shape for node, (_, shape) in self.vectors.items() if node not in plan.recorded}

    def _arranged(self, before: list[str], flags: Mapping[str, str], tick: list[str], after: list[str]) -> list[str]:
        arrays = {*self.rows, *(f"{part.name}_{key}" for part in self.parts for key in part.scratch)}
        rows = (f"{name} = {made_up(name, 'lanes')}[lane]" for name in self.rows)
        kept = (f"{flag} = {place}" for flag, place in flags.items())  # what a call of the loop found, the next knows
        self.before = statements([*rows, *before, *kept, *self.checks], arrays)
        ticks, measured = statements(["time = tick * period", *tick], arrays), statements(self._measured())
        moved = {name for s in (*self.before, *ticks, *measured) for name in s.writes}
        self.back: dict[str, list[str]] = {}  # lines that write a variable back
        for statement in statements(after):
            for name in statement.reads & moved:
                self.back.setdefault(name, []).extend(statement.lines)
        self.varying = self._closure([*self.before, *ticks, *measured])
        segments, behind = self._segments(ticks), self._segments(measured)
        read = {name for segment in (*segments, *behind) if segment.each for name in segment.exposed()}
        read |= {variable(measure.node) for measure in self.plan.measures}
        body = [line for segment in segments for line in self._lines(segment, read)]
        once = [line for s in self.before if self.varying.isdisjoint(s.writes) for line in s.lines]
        each = [s for s in self.before if not self.varying.isdisjoint(s.writes) and not self._is_given(s)]
        first = list(self._lines(Segment("", True, True, each), read)) if each else []
        ticks_of_all = ["for tick in range(first, last):", *_indented(body)]
        values = [line for segment in behind for line in self._lines(segment, read)]
        return ["lane = 0", *once, *first, *ticks_of_all, *values, *self._last()]

    def _measured(self) -> Iterator[str]:
        """Values of the measures that blocks reduce, behind the last tick: each where its wire stands."""
        for name, port in dict.fromkeys(measure.node for measure in self.plan.measures if measure.reduced):
            behaviour = type(self.plan.blocks[name]).output_functions[port]
            function = self.named(self.plan.blocks[name], port, behaviour.function)
            ticks = f"-(-last // {self.plan.schedule.divisors[name]})"
            given = (
                ticks if argument == "tick" else self.argument(name, port, argument) for argument in behaviour.arguments
            )
            yield f"{variable((name, port))} = {function}({', '.join([made_up(word(name), 'c'), *given])})"

    def _constants_of(self, name: str) -> Iterator[str]:
        """Constants of a varied block follow from its parameters, in its lane."""
        block = self.plan.blocks[name]
        if name not in self.computed or self.plan.is_driven(name) or "constants" not in type(block).functions:
            yield from super()._constants_of(name)
            return
        yield from self._parameters_of(name)
        constants, *faults = self.driven(name)
        yield constants
        self.checks += faults
        made = (f"{made_up(word(name), 'c')}.{f}" for f, kind in fields(type(block).constants_class()) if kind is float)
        self.checks += [f"not_finite += {value} - {value}" for value in made]

    def deviate(self, name: str) -> str:
        """As for one run; `_drawn` draws it for all lanes together."""
        drawn = self.stream_and_sample(name)
        self.names["normal_deviates"] = normal_deviates
        self.deviates[made_up(word(name), "normal")] = drawn
        return f"{made_up(word(name), 'normal')} = normal_deviates(seed, {_RUN}, {', '.join(drawn)})"

    def _closure(self, every: list[Statement]) -> frozenset[str]:
        """The variables that may differ from run to run."""
        varying = {_RUN, *(made_up(word(name), key) for name in self.varied for key in ("c", "x"))}
        varying |= {self.parameter(name, p) for name in self.varied for p in type(self.plan.blocks[name]).parameters}
        varying |= {
            variable(node) for node in self.vectors if not isinstance(node, LargestOf) and node[0] in self.varied
        } - self.shared
        while more := {n for s in every if not varying.isdisjoint(s.reads) for n in s.writes} - varying - self.shared:
            varying |= more
        return frozenset(varying)

    def _segments(self, ticks: list[Statement]) -> list[Segment]:
        """The statements of a tick in segments; what is the same for all goes before what differs where it may."""
        made: list[Segment] = []
        for statement in ticks:
            each = not self.varying.isdisjoint(statement.writes)
            straight = not each or (statement.straight and not self._stands_apart(statement))
            one = Segment(statement.guard, each, straight, [statement])
            place = len(made)
            while not each and place and made[place - 1].each and made[place - 1].ignores(statement):
                place -= 1
            if place and made[place - 1].takes(one) and not (self._deviate(made[place - 1]) or self._deviate(one)):
                made[place - 1].statements.append(statement)
            else:
                made.insert(place, one)
        return made

    def _stands_apart(self, statement: Statement) -> bool:
        """Whether it stays out of the arithmetic; what a group is stepped with cannot leave the loop of its steps."""
        return any(name in self.deviates or name in self.contexts for name in statement.writes)

    def _deviate(self, segment: Segment) -> str:
        """The variable of a segment that draws normal deviates, which has no other statement."""
        return next((name for name in segment.written() if name in self.deviates), "")

    def _lines(self, segment: Segment, read: Collection[str]) -> Iterator[str]:
        """A segment as source; `read` are the variables that any segment takes from their places."""
        lines = [line for statement in segment.statements for line in statement.lines]
        if self._deviate(segment):
            lines = [self._drawn(self._deviate(segment))]
        elif segment.each:
            loaded = [line for name in sorted(segment.exposed() & self.varying) for line in self._place(name)[0]]
            kept = [line for name in sorted(segment.written() & set(read)) for line in self._place(name)[1]]
            lines = [f"for lane in range({self.lanes}):", *_indented([*loaded, *lines, *kept])]
        if segment.guard:
            lines = [f"if {segment.guard}:", *_indented(lines)]
        yield from lines

    def _drawn(self, name: str) -> str:
        """The call that draws the deviates of all lanes."""
        self._place(name)
        rows = [self._row("uniform", float), self._row("far", float), self._row("place", int), self._row(name, float)]
        return f"normal_deviates(seed, runs, {', '.join([*self.deviates[name], *rows])})"

    def _row(self, name: str, kind: type) -> str:
        """The places of a variable in all lanes."""
        key = LaneOf(name)
        if key not in self.constants.kinds:
            self.constant(key, kind, 0)
        first = self.constants.kinds[key][1] * self.lanes
        return f"{array_of(kind)}[{first} : {first + self.lanes}]"

    def _last(self) -> Iterator[str]:
        """What is the same in all lanes, written back to each."""
        lines = [line for name, back in self.back.items() if name not in self.varying for line in back]
        for name in sorted(self.rows.keys() - self.varying):
            lines += [
                f"for entry in range({self.rows[name][0]}):",
                f"    {made_up(name, 'lanes')}[lane, entry] = {name}[entry]",
            ]
        if lines:
            yield from [f"for lane in range({self.lanes}):", *_indented(lines)]

    # -- places of variables -----------------------------------------------------------------------------------------

    def _is_given(self, statement: Statement) -> bool:
        """Whether a statement before the ticks only reads what a run is given."""
        given = {FLOATS, INTEGERS, "state_numbers", "state_integers", "scratch", "lane", *self.names}
        given |= {made_up(name, "lanes") for name in self.rows}
        return bool(statement.reads) and statement.reads - statement.writes <= given

    def _place(self, name: str) -> tuple[list[str], list[str]]:
        """Lines that read a variable from its place in memory, and lines that write it there."""
        if name == _RUN:
            return [f"{_RUN} = runs[lane]"], []
        back = self.back.get(name, [])
        given = [line for s in self.before if name in s.writes and self._is_given(s) for line in s.lines]
        if given:
            return given, back
        if not back:
            back = self.back[name] = list(self._made_place(name))
        read = ", ".join(line.split(" = ")[0] for line in back)
        owner = self._owner(name)
        if owner is not None:
            read = f"{self.named(owner, 'Constants', type(owner).constants_class())}({read})"
        return [f"{name} = {read}"], back

    def _made_place(self, name: str) -> Iterator[str]:
        """Lines that write a variable to a place of its own, which no run reads or is given."""
        owner = self._owner(name)
        kind: type = int if name in self.flags else float
        parts = [("", kind)] if owner is None else fields(type(owner).constants_class())
        for part, of in parts:
            key = LaneOf(name, part)
            self.constant(key, of, 0)
            yield f"{self.constants.write(key)} = {name}.{part}" if part else f"{self.constants.write(key)} = {name}"

    def _owner(self, name: str) -> Block | None:
        """The block whose constants the variable holds."""
        return next((block for n, block in self.plan.blocks.items() if made_up(word(n), "c") == name), None)

    # -- what the function is given ----------------------------------------------------------------------------------

    def _views(self) -> Iterator[str]:
        yield f"runs = carray(runs, ({self.lanes},))"
        for slots in (self.constants, self.memory):
            for array, count in slots.counts.items():
                yield f"{slots.prefix}{array} = carray({slots.prefix}{array}, ({(count + 1) * self.lanes},))"
        yield f"scratch = carray(scratch, ({self._scratch() * self.lanes + 1},))"
        for node, (_, shape) in self.vectors.items():
            name = variable(node)
            if name in self.shared:
                yield f"{name} = carray({name}, {shape})"
            else:
                yield f"{made_up(name, 'lanes')} = carray({name}, ({self.lanes}, {shape[0]}))"

    def _scratch_of(self, place: int, length: int) -> str:
        return f"scratch[lane * {self._scratch()} + {place} : lane * {self._scratch()} + {place + length}]"


def _indented(lines: Iterable[str]) -> list[str]:
    return [f"    {line}" for line in lines]
