"""Decorators that stand with or without parentheses: each mistake is answered by the line to write."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, TypeVar, cast

Method = TypeVar("Method", bound=Callable[..., Any])


def bare(method: Method) -> Method:
    """Return a decorator of a kind of block that stands without parentheses, `@Kind.update`."""

    @wraps(method)
    def registered(kind: Any, *given: Any, **named: Any) -> Any:
        if len(given) != 1 or named or not callable(given[0]):
            raise TypeError(f"write @{kind.__name__}.{method.__name__}, without parentheses")
        return method(kind, *given)

    return cast(Method, registered)


def called(example: str) -> Callable[[Method], Method]:
    """Return what makes a decorator of a kind of block that stands with parentheses, `@Kind.output("V")`."""

    def decorated(method: Method) -> Method:
        expected = signature(method)

        @wraps(method)
        def registered(kind: Any, *given: Any, **named: Any) -> Any:
            told = "the parentheses are missing" if given and callable(given[0]) else ""
            try:
                expected.bind(kind, *given, **named)
            except TypeError as error:
                told = told or str(error)
            if told:
                raise TypeError(f"{told}: write @{kind.__name__}.{method.__name__}({example})")
            return method(kind, *given, **named)

        return cast(Method, registered)

    return decorated
