"""Everything that is wrong with the wiring of a graph, all at once."""

from collections import defaultdict
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, islice

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.instance import format_of, shape_of, takes_unit, unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError, Problem, problems_of_table
from proofmass.blocks.declaration.unit_expressions import Unit, UnitError, unit
from proofmass.blocks.declaration.units import convertible
from proofmass.graphs.checks.chopping import chopping_notes
from proofmass.graphs.checks.clocking import clocking_notes
from proofmass.graphs.checks.names_used import as_written, bad_exports, bad_loops, once, unused_parts
from proofmass.graphs.checks.own_functions import own_problems
from proofmass.graphs.checks.rates import base_rate_notes, rate_problems
from proofmass.graphs.checks.requirements import bad_requirements
from proofmass.graphs.checks.sampling import sampling_notes
from proofmass.graphs.checks.schedule import Schedule, schedule
from proofmass.graphs.model.derived import bad_derived
from proofmass.graphs.model.exports import exposed, open_inputs
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside
from proofmass.graphs.model.graph import AnyGraph, Graph, Wire, split
from proofmass.graphs.model.hints import counted
from proofmass.graphs.model.limits import BLOCKS, PROBLEMS, WIRES
from proofmass.graphs.model.measures import MEASURES, bad_display_unit
from proofmass.graphs.model.names import Missing, find_output, find_target
from proofmass.graphs.model.rates import Clock
from proofmass.graphs.model.statistics import STATISTICS

# Beginnings of problems that depend on the values of parameters.
_OF_VALUES = ("the units", "the shapes", "the types", "the formats")


def check(graph: Graph) -> list[Problem]:
    """Return all problems of a graph, each with its place; a graph that can run has only notes.

    A graph with exports may be a part of others, which give it a rate and drive its inputs. If
    these are missing, `check` gives a note, and `checked` refuses to run the graph alone.
    """
    return _looked_at(flatten(graph))[0]


def checked(graph: AnyGraph) -> AnyGraph:
    """Return the graph if it can run; raises `ModelError` with every problem otherwise."""
    scheduled(flatten(graph))
    return graph


def scheduled(flat: FlatGraph) -> Schedule:
    """Return the schedule of a graph that can run; raises `ModelError` with every problem."""
    found, order = _looked_at(flat)
    problems = [problem for problem in found if not problem.note]
    problems += [] if problems or not flat.exports else open_inputs(flat)
    if problems or order is None:
        raise ModelError(problems)
    return order


def _looked_at(flat: FlatGraph) -> tuple[list[Problem], Schedule | None]:
    """All problems with their places, and the schedule if wires and rates are right."""
    order = None
    problems = list(_size(flat))
    if not problems:
        names = chain(_signals(flat), bad_exports(flat), bad_loops(flat), bad_derived(flat), bad_requirements(flat))
        found = chain(rate_problems(flat), _Wiring(flat).problems(), names)
        problems = list(islice(found, 2 * PROBLEMS))
    if not problems:
        try:
            order = schedule(flat)
        except ModelError as error:
            problems = list(error.problems)
    problems += own_problems(flat)
    if not problems:
        problems = list(islice(_notes(flat), PROBLEMS))
    placed = once(flat, [flat.placed(as_written(flat, problem)) for problem in problems])[:PROBLEMS]
    first = flat.root.place.file
    return sorted(placed, key=lambda problem: (problem.file != first, problem.file, problem.line)), order


def check_apart_from(graph: Graph, doubtful: Collection[str]) -> list[Problem]:
    """Problems apart from those that follow from blocks which could not be read.

    Such a block has the default parameters of its kind; its ports are known, and their names can be
    judged.
    """
    known = {*graph.blocks}

    def touched(problem: Problem) -> set[str]:
        where, *rest = (*problem.path, "")
        names = [rest[0]]
        if where == "wires":
            names = [end] if (end := rest[1]) else rest[0].split(" -> ")
        elif where == "probes":
            names = [graph.probes[int(rest[0])].signal]
        elif where == "loops":
            names = [graph.loops[rest[0]].open_at]
        elif where == "measures":
            names = [graph.measures[rest[0]].signal] if rest[0] in graph.measures else []
        elif where == "exports":
            names = [graph.exports.get(rest[0], rest[0])]
        return {name.partition(".")[0] for name in names}

    def follows(problem: Problem) -> bool:
        of_names = problem.path[0] in ("wires", "probes") and not problem.message.startswith(_OF_VALUES)
        return not touched(problem).isdisjoint({*doubtful} - known if of_names else doubtful)

    return [p for p in check(graph) if not p.note and len(p.path) > 1 and not follows(p)]


def _size(graph: FlatGraph) -> Iterator[Problem]:
    if not graph.blocks:
        hint = 'add [blocks.NAME] and below it kind = "Gain"'
        yield Problem(message="the graph has no blocks", key="blocks", hint=hint)
    for count, largest, key in ((len(graph.blocks), BLOCKS, "blocks"), (len(graph.wires), WIRES, "wires")):
        if count > largest:
            yield Problem(message="too many", got=str(count), expected=f"at most {largest}", path=(key,))


class _Wiring:
    """Checks every wire against the ports at its two ends, and finds inputs without a wire."""

    def __init__(self, graph: FlatGraph) -> None:
        self.graph, self.root = graph, graph.root
        self.meant: set[str] = set()  # inputs of a misspelt wire: not reported twice
        self.tried: dict[str, list[str]] = defaultdict(list)  # sources wired to no input

    def problems(self) -> Iterator[Problem]:
        return chain(self._wires(), self._unconnected())

    def _wires(self) -> Iterator[Problem]:
        driven_by: dict[str, str] = {}
        absent: set[str] = set()  # missing blocks, each reported once, however many wires name it
        for wire in sorted(self.graph.wires, key=lambda wire: self.graph.find(("wires", str(wire)))[1]):
            source, target = wire
            key, path = f"wires: {wire}", ("wires", str(wire))
            out, into = find_output(self.graph, source), find_target(self.graph, target)
            if isinstance(out, Missing) and isinstance(into, Missing) and self._backwards(source, target):
                yield Problem(message="the wire is backwards", key=key, hint=f'write "{target} -> {source}"', path=path)
                self.meant.add(source)
                continue
            for end, signal in ((out, source), (into, target)):
                if isinstance(end, Missing) and end.message not in absent:
                    yield Problem(message=end.message, key=key, hint=end.hint, path=(*path, signal))
                    absent |= {end.message} if end.absent else set()
            if isinstance(into, Missing):
                self.meant.add(into.meant)
                if not isinstance(out, Missing) and not split(into.meant)[1]:  # no input is near
                    self.tried[split(target)[0]].append(source)
            if target in driven_by:
                other = driven_by[target]
                yield Problem(
                    message=f"{target} is driven twice",
                    key=key,
                    got=f"{other} and {source}" if other != source else f"two wires from {source}",
                    expected="one wire",
                    hint="remove one of the wires"
                    + ("" if other == source else ", or add the signals with a Sum and wire its output"),
                    path=path,
                )
            driven_by.setdefault(target, source)
            if not isinstance(out, Missing) and not isinstance(into, Missing):
                yield from _mismatches(wire, out, into)

    def _backwards(self, source: str, target: str) -> bool:
        """Return whether a wire leads from an input to an output."""
        ends = find_output(self.graph, target), find_target(self.graph, source)
        return not any(isinstance(end, Missing) for end in ends)

    def _unconnected(self) -> Iterator[Problem]:
        connected = {wire.target for wire in self.graph.wires} | {inside(self.root, signal) for signal in self.meant}
        shown = exposed(self.root)
        for name, block in self.graph.blocks.items():
            for port, declared in type(block).inputs.items():
                signal = f"{name}.{port}"
                if declared.default is not None or signal in connected or "." not in shown.get(signal, signal):
                    continue
                owner, entry = split(shown.get(signal, signal))
                path = owner.rpartition(".")[0]  # of the graph where the wire is missing
                fitting = [s for s in self._fitting(block, declared, path) if split(s)[0] != name]
                tried = self.tried[name][:1]
                del self.tried[name][:1]
                fitting = list(dict.fromkeys([*(s.removeprefix(f"{path}.") for s in tried), *fitting]))[:3]
                yield Problem(
                    message=f"the input {entry} is not connected",
                    expected=f"a wire that carries {_facts(block, declared)}: {declared.doc}",
                    hint=f'add "{fitting[0] if fitting else "block.output"} -> {split(owner)[1]}.{entry}" to wires'
                    + (f"; {' and '.join(fitting[1:])} would fit too" if fitting[1:] else "")
                    + (f', or export it: exports = {{ {entry} = "{split(owner)[1]}.{entry}" }}' if path else ""),
                    path=("blocks", owner),
                )

    def _fitting(self, block: Block, port: Port, path: str) -> list[str]:
        """Fitting outputs of the graph with that path, by their names within it."""
        with suppress(UnitError):
            known = self._outputs.get((path, *_kind(block, port)), [])
            return [signal.removeprefix(f"{path}.") for signal in known]
        return []

    @cached_property
    def _outputs(self) -> dict[tuple[str, Unit, type | Fixed, tuple[int, ...]], list[str]]:
        """Up to four outputs of each graph, unit, type and shape."""
        outputs: dict[tuple[str, Unit, type | Fixed, tuple[int, ...]], list[str]] = {}
        for name, block in self.graph.blocks.items():
            for port, declared in type(block).outputs.items():
                with suppress(UnitError):
                    fitting = outputs.setdefault((split(name)[0], *_kind(block, declared)), [])
                    if len(fitting) < 4:
                        fitting.append(f"{name}.{port}")
        return outputs


def _kind(block: Block, port: Port) -> tuple[Unit, type | Fixed, tuple[int, ...]]:
    """Unit, type and shape of a port; of a fixed-point one its format. Raises `UnitError`."""
    dtype = format_of(block, port.name) if port.dtype is FixedValue else port.dtype
    return unit(unit_of(block, port)), dtype, shape_of(block, port)


def _mismatches(wire: Wire, source: tuple[Block, Port], target: tuple[Block, Port | Parameter]) -> Iterator[Problem]:
    (giver, out), (taker, into) = source, target

    def mismatch(message: str, got: str, expected: str, hint: str) -> Problem:
        key, path = f"wires: {wire}", ("wires", str(wire))
        return Problem(message=message, key=key, got=got, expected=expected, hint=hint, path=path)

    got, expected = unit_of(giver, out), unit_of(taker, into)
    try:
        source_unit, target_unit = unit(got), unit(expected)
    except UnitError as error:
        yield mismatch(f"the units cannot be compared: {error}", got, expected, "write a shorter unit")
    else:
        gain = "FixedGain" if out.dtype is FixedValue else "Gain"
        convert = f'put a {gain} with input_unit = "{got}" and output_unit = "{expected}" between'
        ends = [_unit_to_set(wire.target, taker, into, got), _unit_to_set(wire.source, giver, out, expected)]
        first = 1 if _is_unset(giver, out) and not _is_unset(taker, into) else 0
        convert = f"{ends[first] or ends[1 - first]}{convert}"
        if source_unit.exponents != target_unit.exponents:
            told = f"{source_unit.in_base_units()} is not {target_unit.in_base_units()}; "
            same = "" if "1" in (got, expected) else told  # a number alone needs no telling
            yield mismatch("the units do not match", got, expected, f"{same}{convert}")
        elif not convertible(got, expected):
            yield mismatch("the units do not match", got, expected, f"one turn is 2 pi rad; {convert}")
        elif source_unit != target_unit:
            factor = f"{float(source_unit.factor / target_unit.factor):g}"
            yield mismatch(f"the units differ by a factor of {factor}", got, expected, convert)
    shape = shape_of(taker, into) if isinstance(into, Port) else ()
    kind = into.dtype if isinstance(into, Port) else float
    if shape_of(giver, out) != shape:
        others = [name for name, port in type(giver).outputs.items() if shape_of(giver, port) == shape]
        hint = f"outputs that fit: {', '.join(others)}" if others else "record a vector in probes"
        hint += ", or wire it to an input that takes a vector of the same length" if shape_of(giver, out) else ""
        yield mismatch("the shapes do not match", counted(shape_of(giver, out)), counted(shape), hint)
    elif out.dtype is not kind:
        yield mismatch("the types do not match", _type(out.dtype), _type(kind), _same_type(giver, out.dtype, kind))
    elif kind is FixedValue:
        given_format, wanted_format = format_of(giver, out.name), format_of(taker, into.name)
        if given_format != wanted_format:
            hint = f'put a FixedCast with input_format = "{given_format}", output_format = "{wanted_format}" between'
            yield mismatch("the formats do not match", str(given_format), str(wanted_format), hint)


def _is_unset(block: Block, port: Port | Parameter) -> bool:
    """Return whether the unit of a port is that of a parameter which has its default: nobody may have meant it."""
    declared = type(block).parameters.get(port.unit[1:-1])
    return declared is not None and getattr(block, declared.name) == declared.default


def _unit_to_set(signal: str, block: Block, port: Port | Parameter, wanted: str) -> str:
    """Return which parameter to set where a block at an end of a wire works in any unit, and what it says fits."""
    name, (path, _) = port.unit[1:-1], split(signal)
    if name not in type(block).parameters or "." in path or not takes_unit(block, name, wanted):
        return ""
    return f'set {name} = "{wanted}" under [blocks.{path}], or '


def _type(kind: type) -> str:
    return "fixed" if kind is FixedValue else kind.__name__


def _same_type(source: Block, source_kind: type, kind: type) -> str:
    """A hint for a wire of the wrong type: nothing is converted in silence."""
    fitting = [name for name, port in type(source).outputs.items() if port.dtype is kind]
    if fitting:
        return f"its output {fitting[0]} has that type"
    if kind is FixedValue and source_kind is float:
        return "a FixedQuantiser makes fixed-point values of numbers"
    if source_kind is FixedValue and kind is float:
        return "a FixedToNumber makes numbers of fixed-point values"
    return "an AnalogToDigital makes codes of numbers" if kind is int else "choose an output of that type"


def _facts(block: Block, port: Port) -> str:
    """Unit, type and shape of a port in words, if they are unusual."""
    measure = unit_of(block, port)
    if port.dtype is FixedValue:
        measure = f"{format_of(block, port.name)} fixed-point" + (f" in {measure}" if measure != "1" else "")
    kind = {
        float: f"a number in {measure}" if measure != "1" else "a number",
        int: "an integer",
        bool: "true or false",
        FixedValue: f"a value in {measure}",
    }
    return kind[port.dtype] if not port.shape else f"{counted(shape_of(block, port))}, each {kind[port.dtype]}"


def _signals(graph: FlatGraph) -> Iterator[Problem]:
    """Outputs that probes and measures name."""
    yield from _probes(graph)
    if graph.measures and any(name.partition(".")[0] == MEASURES for name in graph.blocks):
        message, hint = "the name is taken where a graph has measures", "rename the block"
        yield Problem(message=message, hint=hint, path=("blocks", MEASURES))
    for name, measure in graph.measures.items():
        bad, output = problems_of_table("measures", name, "signal"), find_output(graph, measure.signal)
        if isinstance(output, Missing):
            yield bad(output.message, hint=output.hint)
            continue
        own = STATISTICS[measure.statistic].unit_for(unit_of(*output))
        yield from bad_display_unit(measure.unit, own, f"measures.{name}.unit", ("measures", name, "unit"))
        if output[1].dtype is FixedValue:
            yield bad("a fixed-point value cannot be measured", hint="measure the number that it is converted to")
        if shape := shape_of(*output):
            hint = "measure an output of single values"
            yield bad("a vector cannot be measured", got=counted(shape), expected=counted(()), hint=hint)
        try:
            measure.reducer(unit_of(*output), Clock(Fraction(1)))
        except ModelError as error:
            # options that are times are counted in samples once the rates are known
            counted_later = {option.samples for option in STATISTICS[measure.statistic].times.values()}
            for problem in (problem for problem in error.problems if problem.path[0] not in counted_later):
                yield replace(problem, key="", path=("measures", name, *problem.path))


def _probes(graph: FlatGraph) -> Iterator[Problem]:
    probed = set()
    for index, (signal, _, shown_in) in enumerate(graph.probes):
        path, key = ("probes", str(index)), f"probes: {graph.root.probes[index].signal}"
        output = find_output(graph, signal)
        if isinstance(output, Missing):
            yield Problem(message=output.message, key=key, hint=output.hint, path=path)
        else:
            yield from bad_display_unit(shown_in, unit_of(*output), key, path)
        if signal in probed:
            yield Problem(message="probed twice", key=key, hint="remove one of the probes", path=path)
        probed.add(signal)


def _notes(graph: FlatGraph) -> Iterator[Problem]:
    yield from base_rate_notes(graph)
    yield from (replace(problem, note=True) for problem in open_inputs(graph))
    used = {split(wire.source) for wire in graph.wires} | {split(probe.signal) for probe in graph.probes}
    used |= {split(measure.signal) for measure in graph.measures.values()}
    used |= {split(signal) for signal in exposed(graph.root)}
    for name, block in graph.blocks.items():
        kind = type(block)
        if kind.outputs and not any((name, port) in used for port in kind.outputs):
            yield Problem(
                message="none of its outputs is used",
                hint=f"wire {'its' if len(kind.outputs) == 1 else 'one of'} {', '.join(kind.outputs)}, "
                f'or add "{name}.{next(iter(kind.outputs))}" to probes',
                note=True,
                path=("blocks", name),
            ).at(*graph.root.place.find(("blocks", name.partition(".")[0])))  # the line at which a probe can be added
    yield from clocking_notes(graph)
    if graph.root.subgraphs:
        yield from unused_parts(graph)
    yield from sampling_notes(graph)
    yield from chopping_notes(graph)
