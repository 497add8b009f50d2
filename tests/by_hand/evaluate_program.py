"""A program executed statement by statement in Python: what every target has to agree with."""

import ctypes
import ctypes.util
from typing import Any

from proofmass.runner.program import form
from proofmass.runner.program.build import zero
from proofmass.runner.program.operations import EVALUATE

_LIBRARY = ctypes.CDLL(ctypes.util.find_library("m"))


class Part:
    """Entries of a list from one on."""

    def __init__(self, whole: Any, first: int = 0) -> None:
        self.whole, self.first = whole, first

    def __getitem__(self, index: int) -> Any:
        assert index >= 0
        return self.whole[self.first + index]

    def __setitem__(self, index: int, value: Any) -> None:
        assert index >= 0
        self.whole[self.first + index] = value


class _LeftError(Exception):
    """Where a program goes on elsewhere."""


class _LeavesError(_LeftError):
    pass


class _GoesError(_LeftError):
    pass


class _ReturnsError(_LeftError):
    def __init__(self, values: tuple[Any, ...]) -> None:
        self.values = values


def evaluate(function: form.Function, *arguments: Any) -> tuple[Any, ...]:
    """What a function returns for numbers and lists."""
    known: dict[Any, Any] = {}
    for parameter, argument in zip(function.parameters, arguments, strict=True):
        known[parameter] = Part(argument) if isinstance(argument, list) else argument
    for variable in function.variables:
        known[variable] = zero(variable.kind).value
    try:
        _run(function.body, known)
    except _ReturnsError as returned:
        return returned.values
    assert not function.results, "a function that gives results ended without"
    return ()


def _run(region: form.Region, known: dict[Any, Any]) -> None:
    def of(operand: Any) -> Any:
        return operand.value if isinstance(operand, form.Immediate) else known[operand]

    for statement in region:
        match statement:
            case form.Compute(result, operation, operands):
                known[result] = EVALUATE[operation](*map(of, operands))
            case form.Get(result, variable):
                known[result] = known[variable]
            case form.Set(variable, value):
                known[variable] = of(value)
            case form.Load(result, array, index):
                known[result] = known[array][of(index)]
            case form.Store(array, index, value):
                known[array][of(index)] = of(value)
            case form.View(part, whole, first):
                known[part] = Part(known[whole], of(first))
            case form.Call(results, form.External() as function, given):
                known[results[0]] = _of_library(function, *map(of, given))
            case form.Call(results, function, given):
                values = evaluate(
                    function, *(known[a] if isinstance(a, form.Storage | form.Value) else a.value for a in given)
                )
                known.update(zip(results, values, strict=True))
            case form.If(condition, then, otherwise):
                _run(then if of(condition) else otherwise, known)
            case form.For(counter, first, last, step, body):
                for place in range(of(first), of(last), step):
                    known[counter] = place
                    if not _turn(body, known):
                        break
            case form.While(test, condition, body):
                _run(test, known)
                while of(condition) and _turn(body, known):
                    _run(test, known)
            case form.Break():
                raise _LeavesError
            case form.Continue():
                raise _GoesError
            case form.Return(values):
                raise _ReturnsError(tuple(map(of, values)))


def _turn(body: form.Region, known: dict[Any, Any]) -> bool:
    """Whether a loop goes on."""
    try:
        _run(body, known)
    except _LeavesError:
        return False
    except _GoesError:
        pass
    return True


def _of_library(function: form.External, *arguments: float) -> float:
    called = getattr(_LIBRARY, function.symbol)
    called.restype, called.argtypes = ctypes.c_double, [ctypes.c_double] * len(arguments)
    return float(called(*arguments))
