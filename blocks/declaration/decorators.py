"""Decorators and declarations of blocks: mistakes are answered by the line to write."""

from collections.abc import Callable
from dataclasses import Field
from functools import wraps
from inspect import Signature, signature
from typing import Any, TypeVar, cast

from proofmass.blocks.declaration.problem import shown

Method = TypeVar("Method", bound=Callable[..., Any])
OF_A_FUNCTION = 'write @block("V", voltage="V"), with the unit of the output and of each input'


def bare(method: Method) -> Method:
    """Return a decorator of a kind of block that stands without parentheses, `@Kind.update`."""

    @wraps(method)
    def registered(kind: Any, *given: Any, **named: Any) -> Any:
        if len(given) != 1 or named or not callable(given[0]):
            raise TypeError(f"write @{kind.__name__}.{method.__name__}, without parentheses")
        return method(kind, *given)

    return cast(Method, registered)


def called(example: str) -> Callable[[Method], Method]:
    """Return what makes a decorator of a kind that stands with parentheses, `@Kind.output("V")`."""

    def decorated(method: Method) -> Method:
        expected = signature(method)

        @wraps(method)
        def registered(kind: Any, *given: Any, **named: Any) -> Any:
            missing = "the parentheses are missing" if given and callable(given[0]) else ""
            if told := missing or _misfit(expected, (kind, *given), named):
                raise TypeError(f"{told}: write @{kind.__name__}.{method.__name__}({example})")
            return method(kind, *given, **named)

        return cast(Method, registered)

    return decorated


def declares(line: str) -> Callable[[Method], Method]:
    """Return what makes a declaring function answer wrong arguments by the line to write."""

    def decorated(method: Method) -> Method:
        expected = signature(method)

        @wraps(method)
        def declared(*given: Any, **named: Any) -> Any:
            if told := _misfit(expected, given, named):
                raise TypeError(f"{told}: write {line}")
            return method(*given, **named)

        return cast(Method, declared)

    return decorated


def _misfit(expected: Signature, given: tuple[Any, ...], named: dict[str, Any]) -> str:
    """Return why arguments do not fit, or ""."""
    try:
        expected.bind(*given, **named)
    except TypeError as error:
        return str(error)
    return ""


def of_a_function(decorator: Method) -> Method:
    """Return `block` with a cure in each error about its arguments: the unit comes first, inputs by their names."""

    @wraps(decorator)
    def registered(*given: Any, **named: Any) -> Any:
        told = ""
        if given and callable(given[0]):
            told = "the parentheses are missing"
        elif not given and "unit" not in named:
            told = "the unit of the output is missing"
        elif given and "unit" in named:
            told = "the unit of the output is given twice"
        elif len(given) > 1:
            told = "inputs are named"
        for name, value in {**({"unit": given[0]} if given else {}), **named}.items():
            if not told and not isinstance(value, str | Field):
                told = f"{name} is not a unit: {shown(value)}"
        if told:
            raise TypeError(f"{told}; {OF_A_FUNCTION}")
        return decorator(*given, **named)

    return cast(Method, registered)
