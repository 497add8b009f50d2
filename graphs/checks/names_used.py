"""Problems with other names in a graph than those of wires: exports, unused parts, opened loops."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.build import above_of
from proofmass.graphs.model.exports import is_input
from proofmass.graphs.model.flatten import FlatGraph, inside, parts
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.names import Missing, find_any, find_output, is_rate, is_value


def bad_loops(flat: FlatGraph) -> Iterator[Problem]:
    """Yield loops that are opened at something other than an output of single numbers."""
    for path, part in parts(flat.root):
        for name, loop in part.loops.items():
            output = find_output(flat, path + inside(part, loop.open_at))
            message = hint = ""
            if isinstance(output, Missing):
                message, hint = output.message, output.hint
            elif not output[1].is_number:
                kind = "a vector" if output[1].shape else "true or false"
                message, hint = f"{loop.open_at} is {kind}", "open the loop at an output that is one number"
            if message:
                key, where = f"{path}loops.{name}.open_at", ("loops", name, "open_at")
                yield part.placed(Problem(message=message, key=key, got=loop.open_at, hint=hint, path=where))


def bad_exports(flat: FlatGraph) -> Iterator[Problem]:
    """Yield exports of missing ports, and of inputs that are driven inside or exported twice."""
    drivers = defaultdict[str, list[str]](list)
    for wire in flat.wires:
        drivers[wire.target].append(flat.origins[str(wire)].path)
    for path, part in parts(flat.root):
        names: dict[str, str] = {}
        for name, target in part.exports.items():
            signal = path + inside(part, target)
            found = find_any(flat, signal)
            message = hint = ""
            if isinstance(found, Missing) and not is_value(flat.root, signal) and not is_rate(flat, signal):
                message, hint = found.message, found.hint
            elif is_input(flat, signal) and any(driver.startswith(path) for driver in drivers[signal]):
                message, hint = f"{target} is exported and driven inside", "remove the export, or the wire"
            elif is_input(flat, signal) and signal in names:
                message, hint = f"{target} is exported twice", f"remove {name}: it is exported as {names[signal]}"
            names.setdefault(signal, name)
            if message:
                key = f"{path}exports.{name}"
                yield part.placed(Problem(message=message, key=key, got=target, hint=hint, path=("exports", name)))


def unused_parts(flat: FlatGraph) -> Iterator[Problem]:
    """Yield notes on subgraphs with exported outputs of which none is used."""
    used = {above for probe in flat.root.probes for above in above_of(probe.signal)}
    for path, part in parts(flat.root):
        signals = (*(wire.source for wire in part.wires), *part.exports.values())
        used |= {path + above for signal in signals for above in above_of(signal)}
    for path, part in parts(flat.root):
        ends = {name: find_output(flat, path + inside(part, signal)) for name, signal in part.exports.items()}
        outputs = [name for name, end in ends.items() if not isinstance(end, Missing)]
        name = path[:-1]
        if name and outputs and name not in used:
            hint = f'wire one of {", ".join(outputs)}, or add "{name}.{outputs[0]}" to probes'
            yield Problem(message="none of its exported outputs is used", hint=hint, note=True, path=("blocks", name))


def as_written(flat: FlatGraph, problem: Problem) -> Problem:
    """Return a problem of a wire that names its ends as written, after the path of their graph."""
    table, name = (*problem.path, "", "")[:2]
    if table != "wires" or name not in flat.origins or not problem.key.startswith("wires: "):
        return problem
    _, path, wire = flat.origins[name]
    ends = " -> ".join(path + end for end in wire.split(" -> "))
    return replace(problem, key=f"wires: {ends}")


def once(flat: FlatGraph, problems: Iterable[Problem]) -> list[Problem]:
    """Yield the problems of a part that occurs several times for its first occurrence only."""
    first: dict[str, Problem] = {}
    for problem in problems:
        table, name = (*problem.path, "", "")[:2]
        path = problem.key.partition("exports.")[0] if table == "exports" else ""
        if table == "blocks" and "." in name:
            path = f"{split(name)[0]}."
        elif table == "wires" and name in flat.origins:
            path = flat.origins[name].path
        text = str(problem)
        first.setdefault(text.replace(path, "") if path and problem.line else text + problem.key, problem)
    return list(first.values())
