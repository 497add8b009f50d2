"""Functions of a user's own block in the form that engines run, and their problems."""

import ast
import inspect
import types
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.source import SourceError, tree_of
from proofmass.blocks.language import operations
from proofmass.blocks.language.functions import Form, plain_form
from proofmass.blocks.language.refusals import problem_at
from proofmass.blocks.language.scope import MISSING, outer
from proofmass.blocks.language.values import (
    NOTHING,
    NUMBERS,
    ListOf,
    Record,
    TupleOf,
    Type,
    Vector,
    is_record,
    type_of,
)

_NEVER: tuple[Any, ...] = (print, input, open, exec, eval)


def is_own(kind: type[Block]) -> bool:
    """Return whether a block is a user's own, so that its functions must be checked."""
    return not kind.__module__.startswith("proofmass.blocks.")


def form_of(kind: type[Block], behaviour: Behaviour) -> Form | None:
    """Return a function of a block as an engine runs it; None if that is the function itself."""
    if not is_own(kind) or kind.has_formats():
        return None
    return _form(kind, behaviour)


def constants_form(kind: type[Block]) -> Form | None:
    """Return the function `constants` for changing parameters; None if that is the same."""
    behaviour = kind.functions.get("constants")
    if behaviour is None or not is_own(kind) or kind.has_formats():
        return None
    arguments: list[Type] = [float for _ in behaviour.arguments]
    result = type_of(behaviour.returns)
    return plain_form(plain(behaviour), (Record(kind.parameters_class()), *arguments), result)


def problems_of(kind: type[Block]) -> list[Problem]:
    """Return everything in the functions of a block that engines cannot run to the same bits."""
    if not is_own(kind):
        return []
    problems = list(_bad_types(kind))
    if "constants" in kind.functions and kind.constants_class() is None and not kind.has_formats():
        return [_of(kind, problem) for problem in problems]  # nothing says what the first argument of the others is
    looped = [*kind.output_functions.values(), *(b for name, b in kind.functions.items() if name in LOOPED)]
    looped += [*kind.corners.values(), *(behaviour for pair in kind.events.values() for behaviour in pair)]
    for behaviour in looped:
        form = form_of(kind, behaviour)
        problems += form.problems if form else _unrepeatable(plain(behaviour), _NEVER)
    once = [b.function for name, b in kind.functions.items() if name not in LOOPED]
    for function in (*once, *([kind.requirements] if kind.requirements else [])):
        if isinstance(function, types.FunctionType):
            problems += _unrepeatable(function, ())
    return [_of(kind, problem) for problem in dict.fromkeys(problems)]


def driven_problems(kind: type[Block]) -> list[Problem]:
    """Return why the constants of a block cannot be computed again in every tick."""
    form = constants_form(kind)
    return [_of(kind, problem) for problem in form.problems] if form else []


LOOPED = ("update", "derivative", "fold")


def _form(kind: type[Block], behaviour: Behaviour) -> Form:
    ports = {name: port for name, port in kind.outputs.items() if kind.output_functions.get(name) is behaviour}
    port = next(iter(ports.values()), None)
    updates = behaviour is kind.functions.get("update")
    named = zip(behaviour.arguments, behaviour.meanings, strict=True)
    arguments = [_argument(kind, name, meaning, port, updates) for name, meaning in named]
    result: Type = NOTHING
    state = kind.state_class()
    clearances = [*kind.corners.values(), *(clearance for clearance, _ in kind.events.values())]
    if port is not None:
        result = NOTHING if port.shape else type_of(port.dtype)
    elif behaviour in clearances:
        result = float
    elif state is not None:
        result = type_of(state)
    return plain_form(plain(behaviour), (Record(kind.constants_class()), *arguments), result)


def _argument(kind: type[Block], name: str, meaning: Meaning, port: Any, updates: bool) -> Type:
    """Return the type of an argument."""
    if meaning.number is not None:
        return meaning.number
    match meaning:
        case Meaning.STATE:
            return type_of(kind.state_class())
        case Meaning.OUT:
            return Vector(type_of(port.dtype), writable=True, cleared=True)
        case Meaning.BUFFER:
            return Vector(type_of(kind.buffers[name].dtype), writable=updates and not kind.buffers[name].recorded)
        case Meaning.INPUT:
            declared = kind.inputs[name]
            return Vector(type_of(declared.dtype), writable=False) if declared.shape else type_of(declared.dtype)
        case _:
            raise TypeError(f"{meaning.name} has no type")


def plain(behaviour: Behaviour) -> types.FunctionType:
    """Return the function of a behaviour without what is wrapped around it."""
    function: Any = behaviour.function
    plain: types.FunctionType = inspect.unwrap(getattr(function, "py_func", function))
    return plain


def _bad_types(kind: type[Block]) -> Iterator[Problem]:
    """Yield fields of state and constants of types that engines do not have."""
    for what, record in (("State", kind.state_class()), ("Constants", kind.constants_class())):
        if record is None and (what == "State" or kind.has_formats()):
            continue
        if record is None or not is_record(record):
            yield Problem(
                message=f"what {'update' if what == 'State' else 'constants'} returns is not declared",
                key="update" if what == "State" else "constants",
                got=str(record),
                expected="a NamedTuple",
                hint=f"class {what}(NamedTuple): ..., and -> {what} at the function",
            )
            continue
        for field, of in Record(record).fields.items():
            if of not in NUMBERS and not (what == "Constants" and _numbers(of)) and not kind.has_formats():
                yield Problem(
                    message=f"the field {field} of {record.__name__} has a type that no engine holds",
                    key=field,
                    got=inspect.formatannotation(record.__annotations__[field]),
                    expected="float, int or bool" + (", or a tuple of them" if what == "Constants" else ""),
                    hint="keep a vector in a Buffer" if what == "State" else "",
                )


def _numbers(kind: Type) -> bool:
    """Return whether values of a type are tuples of numbers, or of such tuples."""
    entries = kind.entries if isinstance(kind, TupleOf) else (kind.entry,) if isinstance(kind, ListOf) else ()
    return bool(entries) and all(entry in NUMBERS or _numbers(entry) for entry in entries)


def _unrepeatable(function: types.FunctionType, never: tuple[Any, ...]) -> list[Problem]:
    """Return calls with another result each time, in a function and in those that it calls."""
    problems, left, visited = list[Problem](), [function], set[types.FunctionType]()
    while left:
        here = left.pop()
        if here in visited or here.__module__.startswith("proofmass."):
            continue
        visited.add(here)
        try:
            tree = tree_of(here)
        except SourceError:
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Global | ast.Nonlocal):
                problems.append(problem_at(here, node, "a function of a block changes nothing outside of it", ""))
            if not isinstance(node, ast.Call):
                continue
            target = looked_up(here, node.func)
            if isinstance(target, types.FunctionType):
                left.append(target)
            first = looked_up(here, _first(node.func))
            place = first.__name__.partition(".")[0] if isinstance(first, types.ModuleType) else ""
            shown = ast.unparse(node.func)
            for name in (*operations.modules_of(target), place):
                if name in operations.UNREPEATABLE:
                    message = f"{shown}() would make a run another each time"
                    problems.append(problem_at(here, node, message, operations.UNREPEATABLE[name]))
                    break
            if any(target is each for each in never):
                problems.append(
                    problem_at(here, node, f"{shown}() is not compiled", operations.INSTEAD.get(target, ""))
                )
    return problems


def _first(node: ast.expr) -> ast.expr:
    while isinstance(node, ast.Attribute):
        node = node.value
    return node


def looked_up(function: types.FunctionType, node: ast.expr) -> Any:
    """Return the object of a name outside of a function, or of a name in a module; else `MISSING`."""
    if isinstance(node, ast.Name):
        return outer(function, node.id)
    if isinstance(node, ast.Attribute):
        owner = looked_up(function, node.value)
        return getattr(owner, node.attr, MISSING) if isinstance(owner, types.ModuleType) else MISSING
    return MISSING


def _of(kind: type[Block], problem: Problem) -> Problem:
    """Return the problem with the block's name before the function's."""
    return replace(problem, key=f"{kind.__name__}.{problem.key}" if problem.key else kind.__name__)
