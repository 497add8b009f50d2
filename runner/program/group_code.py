"""Source of a group of continuous blocks: its functions, and what the loop does with them in each tick."""

from collections.abc import Iterator
from typing import Any

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.graphs.checks.schedule import ConstantsOf, Step
from proofmass.runner.continuous.exact_hold import matrix_exponential, scale_rows, sum_rows
from proofmass.runner.continuous.integrate import integrate
from proofmass.runner.continuous.methods import EXPLICIT, explicit_step
from proofmass.runner.continuous.radau import radau_step, scratch
from proofmass.runner.plan.groups import state_fields
from proofmass.runner.plan.keys import SolverNumber, made_up, variable, word
from proofmass.runner.plan.solver import Solver
from proofmass.runner.program.loop_code import LoopCode
from proofmass.runner.program.pieces import Call, Pieces, fields, spoilt

_ASSEMBLED = ("matrix", "grown", "square", "scale")  # scratch of the matrix exponential
_STEPPED = ("x", "moved", "error")
MANY_COLUMNS = 24  # of an exact group, beyond which a loop sums its rows: their text takes minutes to compile
_FAILED = "failed"  # whether anything failed in a function of an instant


class GroupCode:
    """Writes the source of one group."""

    def __init__(self, pieces: Pieces, solver: Solver) -> None:
        self.pieces, self.solver, self.group, self.name = pieces, solver, solver.group, solver.name
        self.blocks = pieces.plan.blocks
        self.columns = len(self.group.states) + len(self.group.inputs) + len(self.group.ramps)
        named = enumerate(self.group.loops)
        self.loops = [LoopCode(pieces, loop, f"{self.name}_loop_{number}") for number, loop in named]
        self.scratch: dict[str, int] = {}  # names of arrays with their lengths
        if solver.exact:
            self.scratch = dict.fromkeys(_ASSEMBLED, self.columns * self.columns)
            self.scratch["used"] = sum(len(fields(type(self.blocks[m]).constants_class())) for m in self._driven())
            self.scratch["used"] += len(solver.factors)
        elif not solver.exact:
            self.scratch = dict.fromkeys(_STEPPED, len(self.group.states))
            self.scratch["clear"] = self.scratch["side"] = self.group.watched
            if not solver.tolerance:
                self.scratch["largest"] = len(self.group.states)
            if solver.method == "radau":
                self.scratch |= {f"work_{i}": n for i, n in enumerate(scratch(len(self.group.states)))}
        for loop in self.loops:
            self.scratch |= {f"{loop.name.removeprefix(f'{self.name}_')}_{key}": n for key, n in loop.scratch.items()}

    def functions(self) -> Iterator[str]:
        """Functions that stand before the loop."""
        for loop in self.loops:
            yield from loop.functions()
        yield from self._rates()
        if self.solver.exact:
            yield from self._assemble()
            return
        yield from self._radau() if self.solver.method == "radau" else self._explicit()
        if not self._is_fixed():
            yield from self._clearances()
            yield from self._then()

    def inlined(self) -> Iterator[str]:
        """Functions that the compiler takes into their callers: steps of fixed length are the whole loop."""
        if not self.loops:
            yield f"{self.name}_rates"
        if self._is_fixed():
            yield f"{self.name}_step"

    def before(self) -> Iterator[str]:
        """Numbers that the loop is given."""
        if not self.solver.exact:
            yield f"{self.name}_substeps = {self._number('substeps', int, self.solver.substeps)}"
            yield f"{self.name}_length = period / {self.name}_substeps"
            if not self._is_fixed():
                yield f"{self.name}_tolerance = {self._number('tolerance', float, self.solver.tolerance)}"
                yield f"{self.name}_precision = {self._number('precision', float, self.solver.precision)}"
        elif not self.solver.renewed:
            yield self._assembled()
            for i in range(0 if self._is_large() else len(self.group.states)):
                for j in range(self.columns):
                    yield f"{self.name}_{i}_{j} = {self.name}_matrix[{i * self.columns + j}]"

    def move(self) -> Iterator[str]:
        """The states one tick later, in the order of the reference engine."""
        if self.solver.exact:
            yield from self._by_matrices()
        else:
            yield from self._by_steps()

    # -- linear groups -------------------------------------------------------------------------------------------

    def _by_matrices(self) -> Iterator[str]:
        if self.solver.renewed:
            yield from self._renewed()
        terms = [f"{made_up(word(block), 'x')}.{name}" for block, name in self.group.states]
        first = self.solver.factors[:1]
        terms += ["1.0" if node in first else variable(node) for node in self.group.inputs]
        terms += [f"({made_up(variable(node), 'next')} - {variable(node)})" for node in self.group.ramps]
        if self._is_large():
            yield from self._by_rows(terms)
            return
        moved = [made_up(variable(state), "moved") for state in self.group.states]
        for i, name in enumerate(moved):
            factors = (f"{self._factor(i, j)} * {term}" for j, term in enumerate(terms))
            yield f"{name} = {' + '.join(factors)}"
        yield from self._states(moved)

    def _is_large(self) -> bool:
        return self.columns > MANY_COLUMNS and not self.solver.renewed and not self.pieces.lanes

    def _by_rows(self, terms: list[str]) -> Iterator[str]:
        """The same sums in the same order; what the matrices were assembled in is free after that."""
        self.pieces.names["sum_rows"] = sum_rows
        yield from (f"{self.name}_grown[{j}] = {term}" for j, term in enumerate(terms))
        arrays = ", ".join(f"{self.name}_{key}" for key in ("matrix", "grown", "square"))
        yield f"sum_rows({arrays}, {len(self.group.states)}, {self.columns})"
        yield from self._states([f"{self.name}_square[{i}]" for i in range(len(self.group.states))])

    def _factor(self, i: int, j: int) -> str:
        return f"{self.name}_matrix[{i * self.columns + j}]" if self.solver.renewed else f"{self.name}_{i}_{j}"

    def _renewed(self) -> Iterator[str]:
        """The matrices, when a constant or factor that they follow from is another than in the tick before."""
        used = [
            f"{made_up(word(m), 'c')}.{f}"
            for m in self._driven()
            for f, _ in fields(type(self.blocks[m]).constants_class())
        ]
        used += [variable(node) for node in self.solver.factors]
        yield f"if {' or '.join(f'{value} != {self.name}_used[{i}]' for i, value in enumerate(used))}:"
        yield from (f"    {self.name}_used[{i}] = {value}" for i, value in enumerate(used))
        yield f"    {self._assembled()}"

    def _assembled(self) -> str:
        arrays = ", ".join(f"{self.name}_{key}" for key in _ASSEMBLED)
        held = [variable(node) for node in self.solver.factors]
        return f"{self.name}_assemble(({', '.join([*self._constants(), *held])},), period, {arrays})"

    def _assemble(self) -> Iterator[str]:
        """Transition and entry from the rates for unit states and inputs."""
        self.pieces.names |= {"matrix_exponential": matrix_exponential, "scale_rows": scale_rows}
        n, m, size = len(self.group.states), len(self.group.inputs), self.columns
        yield f"def {self.name}_assemble(constants, period, matrix, grown, square, scale):"
        yield f"    for entry in range({size * size}):"
        yield "        matrix[entry] = 0.0"
        known = [*self._constants(), *(variable(node) for node in self.solver.factors)]
        held = {n + self.group.inputs.index(node): variable(node) for node in self.solver.factors}
        if held:
            yield f"    ({', '.join(known)},) = constants"
            offset = ", ".join(f"offset_{i}" for i in range(n))
            yield f"    ({offset},) = {self._rates_for(-1, held)}"
        if self._is_large():
            yield from self._columns()
        for j in range(0 if self._is_large() else n + m):
            places = ", ".join(f"matrix[{i * size + j}]" for i in range(n))
            if j not in held:
                yield f"    ({places},) = {self._rates_for(j, held)}"
                if held:
                    yield from (f"    matrix[{i * size + j}] -= offset_{i}" for i in range(n))
            elif j == next(iter(held)):
                yield from (f"    matrix[{i * size + j}] = offset_{i}" for i in range(n))
        yield f"    scale_rows(matrix, {n}, {n + m}, {size}, period)"
        for number, node in enumerate(self.group.ramps):
            yield f"    matrix[{(n + self.group.inputs.index(node)) * size + n + m + number}] = 1.0"
        yield f"    matrix_exponential(matrix, {size}, grown, square, scale)"
        yield ""
        yield ""

    def _columns(self) -> Iterator[str]:
        """Columns in a loop, in the scratch of the matrix exponential."""
        n, m = len(self.group.states), len(self.group.inputs)
        point, places = [f"grown[{i}]" for i in range(n + m)], ", ".join(f"square[{i}]" for i in range(n))
        still = ["0.0"] * (len(self.group.ramps) + len(self.group.guesses) + 1)
        context = f"({', '.join(['*constants', *point[n:], *still])},)"
        yield f"    for column in range({n + m}):"
        yield f"        for entry in range({n + m}):"
        yield "            grown[entry] = 0.0"
        yield "        grown[column] = 1.0"
        yield f"        ({places},) = {self.name}_rates({context}, {', '.join(['0.0', *point[:n]])})"
        yield f"        for row in range({n}):"
        yield f"            matrix[row * {self.columns} + column] = square[row]"

    def _rates_for(self, unit: int, held: dict[int, str]) -> str:
        """The rates for a unit state or input, the factors as they are."""
        n, m = len(self.group.states), len(self.group.inputs)
        point = [held.get(i, repr(float(i == unit))) for i in range(n + m)]
        still = ["0.0"] * (len(self.group.ramps) + len(self.group.guesses) + 1)
        constants = self._constants() if held else ["*constants"]
        context = f"({', '.join([*constants, *point[n:], *still])},)"
        return f"{self.name}_rates({context}, {', '.join(['0.0', *point[:n]])})"

    # -- groups that are stepped -----------------------------------------------------------------------------------

    def _by_steps(self) -> Iterator[str]:
        slopes = [variable(node) for node in self.group.ramps]
        for name in slopes:
            yield f"{made_up(name, 'slope')} = ({made_up(name, 'next')} - {name}) / period"
        inputs = [*(variable(node) for node in self.group.inputs), *(made_up(name, "slope") for name in slopes)]
        guesses = [variable(node) for node in self.group.guesses]
        context = f"({', '.join([*self._constants(), *inputs, *guesses, 'time'])},)"
        if self.solver.method == "radau":
            work = ", ".join(f"{self.name}_{key}" for key in self.scratch if key.startswith("work_"))
            context = f"({context}, {self.name}_largest, ({work}))"
        yield f"{self.name}_context = {context}"
        for i, (block, name) in enumerate(self.group.states):
            yield f"{self.name}_x[{i}] = {made_up(word(block), 'x')}.{name}"
        x, error = f"{self.name}_x", f"{self.name}_error"
        if self._is_fixed():
            yield f"for substep in range({self.name}_substeps):"
            at = f"time + substep * {self.name}_length"
            yield f"    {self.name}_step({self.name}_context, {at}, {self.name}_length, {x}, {x}, {error})"
        else:
            self.pieces.names["integrate"] = integrate
            functions = ", ".join(f"{self.name}_{function}" for function in ("step", "clearances", "then", "context"))
            accuracy = f"{self.name}_length, {self.name}_tolerance, {self.solver.order}, {self.name}_precision"
            arrays = ", ".join(f"{self.name}_{key}" for key in (*_STEPPED, "largest", "clear", "side"))
            events = len(self.group.events)
            yield f"{self.name}_status = integrate({functions}, time, period, {accuracy}, {arrays}, {events})"
            yield f"not_finite += 0.0 * (1e308 * (10.0 * {self.name}_status))  # NaN where it failed"
        yield from self._states([f"{x}[{i}]" for i in range(len(self.group.states))])

    def _explicit(self) -> Iterator[str]:
        """The formula of the method, run on text instead of numbers."""
        count, calls = len(self.group.states), 0
        lines = list[str]()

        def rates(time: "_Text", there: list["_Text"]) -> list["_Text"]:
            nonlocal calls
            calls += 1
            names = [f"rate_{calls}_{i}" for i in range(count)]
            lines.append(f"({', '.join(names)},) = {self.name}_rates(context, {', '.join(map(str, [time, *there]))})")
            return [_Text(name) for name in names]

        x = [_Text(f"x{i}") for i in range(count)]
        moved, *error = explicit_step(EXPLICIT[self.solver.method], rates, _Text("time"), _Text("length"), x)
        yield f"def {self.name}_step(context, time, length, x, moved, error):"
        yield from (f"    x{i} = x[{i}]" for i in range(count))
        yield from (f"    {line}" for line in lines)
        yield from (f"    moved[{i}] = {value}" for i, value in enumerate(moved))
        for estimate in error:
            yield from (f"    error[{i}] = {value}" for i, value in enumerate(estimate))
        yield ""
        yield ""

    def _radau(self) -> Iterator[str]:
        self.pieces.names["radau_step"] = radau_step
        states = range(len(self.group.states))
        yield f"def {self.name}_rates_into(context, time, x, out):"
        values = ", ".join(f"x[{i}]" for i in states)
        yield f"    ({', '.join(f'out[{i}]' for i in states)},) = {self.name}_rates(context, time, {values})"
        yield ""
        yield ""
        yield f"def {self.name}_step(context, time, length, x, moved, error):"
        into = f"{self.name}_rates_into"
        yield f"    radau_step({into}, context[0], time, length, x, moved, error, context[1], context[2])"
        yield ""
        yield ""

    # -- functions of an instant -----------------------------------------------------------------------------------

    def _rates(self) -> Iterator[str]:
        """Derivatives of all states; modes stand still."""
        arguments = ", ".join(f"x{i}" for i in range(len(self.group.states)))
        yield f"def {self.name}_rates(context, time, {arguments}):"
        lines = list(self._known("context", [f"x{i}" for i in range(len(self.group.states))]))
        made = list[str]()
        for name in self.group.blocks:
            moving = "derivative" in type(self.blocks[name]).functions
            if moving:
                call = self.pieces.call(name, "derivative", "derivative")
                lines += self._kept(name, "derivative", made_up(word(name), "rates"), call)
            for field, kind in state_fields(self.blocks[name]):
                made.append(f"{made_up(word(name), 'rates')}.{field}" if moving and kind is float else "0.0")
        yield from self._begun(lines)
        yield f"    return ({', '.join(self._sound(value, lines) for value in made)},)"
        yield ""
        yield ""

    def _clearances(self) -> Iterator[str]:
        yield f"def {self.name}_clearances(context, time, x, clear):"
        lines = list(self._instant())
        for number, (name, event) in enumerate(self.group.events):
            lines += self._kept(name, event, f"clearance_{number}", self._event(name, event, 0))
        for number, (name, corner) in enumerate(self.group.corners, start=len(self.group.events)):
            call = self._watched(name, corner, type(self.blocks[name]).corners[corner])
            lines += self._kept(name, corner, f"clearance_{number}", call)
        yield from self._begun(lines)
        for number in range(self.group.watched):
            yield f"    clear[{number}] = {self._sound(f'clearance_{number}', lines)}"
        yield "    return"
        yield ""
        yield ""

    def _then(self) -> Iterator[str]:
        yield f"def {self.name}_then(context, time, x, which):"
        lines = list(self._instant())
        for number, (name, event) in enumerate(self.group.events):
            then = made_up(word(name), "then")
            lines.append(f"    if which == {number}:")
            lines += (f"    {line}" for line in self._kept(name, event, then, self._event(name, event, 1)))
            for field, _ in state_fields(self.blocks[name]):
                lines.append(f"        x[{self.group.states.index((name, field))}] = {then}.{field}")
        yield from self._begun(lines)
        if _failing(lines):
            yield f"    x[0] = {self._sound('x[0]', lines)}"
        yield "    return"
        yield ""
        yield ""

    def _event(self, name: str, event: str, part: int) -> Call:
        return self._watched(name, event, type(self.blocks[name]).events[event][part])

    def _watched(self, name: str, watched: str, behaviour: Behaviour) -> Call:
        arguments = [made_up(word(name), "c"), *(self.pieces.argument(name, watched, a) for a in behaviour.arguments)]
        return self.pieces.called(name, behaviour.function.__name__, behaviour, arguments)

    def _kept(self, name: str, function: str, target: str, call: Call) -> Iterator[str]:
        return (f"    {line}" for line in self.pieces.kept(name, function, target, call, _FAILED))

    def _begun(self, lines: list[str]) -> list[str]:
        """The lines of a function, behind one that says that nothing has failed, where anything can."""
        return [f"    {_FAILED} = False", *lines] if _failing(lines) else lines

    def _sound(self, value: str, lines: list[str]) -> str:
        """A number that is NaN where anything failed in the lines before: the loop looks for that."""
        if not _failing(lines):
            return value
        self.pieces.names["spoilt"] = spoilt
        return f"spoilt({value}, {_FAILED})"

    def _instant(self) -> Iterator[str]:
        context = "context[0]" if self.solver.method == "radau" else "context"
        if self.group.watched:
            yield from self._known(context, [f"x[{i}]" for i in range(len(self.group.states))])

    def _known(self, context: str, x: list[str]) -> Iterator[str]:
        """Everything that the functions of the blocks are given at an instant."""
        slopes = [made_up(variable(node), "slope") for node in self.group.ramps]
        inputs = [variable(node) for node in self.group.inputs]
        guesses = [variable(node) for node in self.group.guesses]
        yield f"    ({', '.join([*self._constants(), *inputs, *slopes, *guesses, 'start'])},) = {context}"
        for node, slope in zip(self.group.ramps, slopes, strict=True):
            yield f"    {variable(node)} = {variable(node)} + {slope} * (time - start)"
        yield from (f"    {line}" for line in self._states(x))
        for step in self.group.nodes:
            yield from (f"    {line}" for line in self._node(step))

    def _node(self, node: Step) -> Iterator[str]:
        if isinstance(node, ConstantsOf):
            yield from self.pieces.driven(node.block, _FAILED)
        elif node in self.group.guesses:
            for loop in self.loops:
                yield from loop.at(node)
        else:
            name, port = node
            yield from self.pieces.kept(name, port, variable(node), self.pieces.call(name, port, port), _FAILED)

    # -- pieces ----------------------------------------------------------------------------------------------------

    def _states(self, values: list[str]) -> Iterator[str]:
        """The states of the blocks from floats."""
        read = {float: "{}", bool: "({} != 0.0)", int: "int({})"}
        typed = iter([read[kind].format(value) for kind, value in zip(self.group.kinds, values, strict=True)])
        for name in self.group.blocks:
            made: Any = type(self.blocks[name]).state_class()
            own = ", ".join(next(typed) for _ in made._fields)
            yield f"{made_up(word(name), 'x')} = {self.pieces.named(self.blocks[name], 'State', made)}({own})"

    def _constants(self) -> list[str]:
        """What holds the constants of the members, or what they are made of within the group; scratch of the loops."""
        held = list[str]()
        for member in self.group.members:
            if ConstantsOf(member) in self.group.nodes:
                drivers = self.pieces.plan.schedule.drivers
                made = fields(type(self.blocks[member]).parameters_class())
                held += [self.pieces.parameter(member, p) for p, _ in made if (member, p) not in drivers]
                held += [made_up(word(member), "period")] if "constants" in type(self.blocks[member]).functions else []
            else:
                held.append(made_up(word(member), "c"))
        return [*held, *(f"{loop.name}_{key}" for loop in self.loops for key in loop.scratch)]

    def _driven(self) -> list[str]:
        """Members whose constants change from tick to tick."""
        return [member for member in self.group.members if self.pieces.plan.is_driven(member)]

    def _is_fixed(self) -> bool:
        return not self.solver.tolerance and not self.group.watched

    def _number(self, number: str, kind: type, value: float) -> str:
        return self.pieces.constant(SolverNumber(self.name, number), kind, value)


def _failing(lines: list[str]) -> bool:
    """Whether anything can fail in some lines."""
    return any(line.lstrip().startswith(f"{_FAILED} |=") for line in lines)


class _Text:
    """A number in the source: arithmetic with it is written down, not done."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __str__(self) -> str:
        return self.text

    def __add__(self, other: object) -> "_Text":
        return _Text(f"({self} + {other})")

    def __mul__(self, other: object) -> "_Text":
        return _Text(f"({self} * {other})")

    def __rmul__(self, other: object) -> "_Text":
        return _Text(f"({other!r} * {self})")
