"""Ways through the regions of a function that several readers of programs take."""

from collections.abc import Iterator

from proofmass.runner.program.form import (
    Array,
    Call,
    Compute,
    Constant,
    For,
    Get,
    If,
    Load,
    Operand,
    Region,
    Return,
    Set,
    Statement,
    Store,
    Value,
    View,
    While,
)


def regions(statement: Statement) -> tuple[Region, ...]:
    """Regions inside a statement."""
    match statement:
        case If(_, then, otherwise):
            return then, otherwise
        case For():
            return (statement.body,)
        case While(test, _, body):
            return test, body
        case _:
            return ()


def statements(region: Region) -> Iterator[Statement]:
    """All statements of a region, those inside others included, in the order of the text."""
    for statement in region:
        yield statement
        for inner in regions(statement):
            yield from statements(inner)


def operands(statement: Statement) -> tuple[Operand | Array, ...]:
    """What a statement itself reads; the condition of `While` is read at the end of its test."""
    match statement:
        case Compute(_, _, read):
            return read
        case Set(_, value):
            return (value,)
        case Load(_, array, index):
            return array, index
        case Store(array, index, value):
            return array, index, value
        case View(_, whole, first):
            return whole, first
        case Call(_, _, arguments):
            return arguments
        case If(condition) | While(_, condition):
            return (condition,)
        case For(_, first, last):
            return first, last
        case Return(values):
            return values
        case _:
            return ()


def results(statement: Statement) -> tuple[Value, ...]:
    """Values that a statement itself defines."""
    match statement:
        case Compute(result) | Get(result) | Load(result):
            return (result,)
        case Call(several):
            return several
        case For(counter):
            return (counter,)
        case _:
            return ()


def used_once(region: Region) -> frozenset[Value]:
    """Results of operations that are read once, in the region that they are computed in: parts of an expression."""
    found: set[Value] = set()
    _uses(region, {}, found)
    return frozenset(found)


def _uses(region: Region, uses: dict[Value, int], found: set[Value]) -> None:
    """Count reads; add to `found` the values of the region that only its own statements read, one of them, once."""
    own, direct = [], set[Value]()
    for statement in region:
        for operand in operands(statement):
            if not isinstance(operand, Array | Constant):
                uses[operand] = uses.get(operand, 0) + 1
                if not isinstance(statement, While):
                    direct.add(operand)
        for inner in regions(statement):
            _uses(inner, uses, found)
        if isinstance(statement, Compute):
            own.append(statement.result)
    found.update(value for value in own if uses.get(value) == 1 and value in direct)
