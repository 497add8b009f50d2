"""Traversals of the regions of a function, shared by several readers of programs."""

from collections.abc import Iterator

from proofmass.runner.program import form


def regions(statement: form.Statement) -> tuple[form.Region, ...]:
    """Regions inside a statement."""
    match statement:
        case form.If(_, then, otherwise):
            return then, otherwise
        case form.For():
            return (statement.body,)
        case form.While(test, _, body):
            return test, body
        case _:
            return ()


def statements(region: form.Region) -> Iterator[form.Statement]:
    """All statements of a region, nested ones included, in the order of the text."""
    for statement in region:
        yield statement
        for inner in regions(statement):
            yield from statements(inner)


def operands(statement: form.Statement) -> tuple[form.Operand | form.Storage, ...]:
    """Operands of a statement itself; the condition of `While` is read at the end of its test."""
    match statement:
        case form.Compute(_, _, read):
            return read
        case form.Set(_, value):
            return (value,)
        case form.Load(_, array, index):
            return array, index
        case form.Store(array, index, value):
            return array, index, value
        case form.View(_, whole, first):
            return whole, first
        case form.Call(_, _, arguments):
            return arguments
        case form.If(condition) | form.While(_, condition):
            return (condition,)
        case form.For(_, first, last):
            return first, last
        case form.Return(values):
            return values
        case _:
            return ()


def results(statement: form.Statement) -> tuple[form.Value, ...]:
    """Values that a statement itself defines."""
    match statement:
        case form.Compute(result) | form.Get(result) | form.Load(result):
            return (result,)
        case form.Call(several):
            return several
        case form.For(counter):
            return (counter,)
        case _:
            return ()


def used_once(region: form.Region) -> frozenset[form.Value]:
    """Results that are read once, in the region that computes them: parts of an expression."""
    values: set[form.Value] = set()
    _uses(region, {}, values)
    return frozenset(values)


def _uses(region: form.Region, uses: dict[form.Value, int], once: set[form.Value]) -> None:
    """Count reads; add to `once` the values of the region that just one of its own statements reads, once."""
    results_here, direct = [], set[form.Value]()
    for statement in region:
        for operand in operands(statement):
            if not isinstance(operand, form.Storage | form.Immediate):
                uses[operand] = uses.get(operand, 0) + 1
                if not isinstance(statement, form.While):
                    direct.add(operand)
        for inner in regions(statement):
            _uses(inner, uses, once)
        if isinstance(statement, form.Compute):
            results_here.append(statement.result)
    once.update(value for value in results_here if uses.get(value) == 1 and value in direct)
