"""A registered function of a block: the meaning of its arguments and the type of its result."""

import dataclasses
import dis
import inspect
import re
import typing
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from proofmass.blocks.declaration.arguments import Meaning, meaning_of
from proofmass.blocks.declaration.problem import did_you_mean


@dataclasses.dataclass(frozen=True)
class Behaviour:
    """A registered function, with names and meanings of its arguments after the first."""

    function: Callable[..., Any]
    arguments: tuple[str, ...]
    meanings: tuple[Meaning, ...]
    returns: Any
    reads_constants: bool  # an output may be just a field of the state

    def named(self, known: Mapping[str, Any]) -> Iterator[Any]:
        """Yield its arguments after the first, of those that are known by name."""
        return (known[name] for name in self.arguments)


def bound(
    owner: str,
    function: Callable[..., Any],
    allowed: Collection[str],
    inputs: Collection[str],
    buffers: Collection[str],
) -> Behaviour:
    """Return the behaviour of a function whose arguments after the first are all `allowed`."""
    names = list(inspect.signature(function).parameters)
    unknown = [name for name in names[1:] if name not in allowed]
    if names and names[0] in {*allowed, *inputs, *buffers} - {"p", "c"}:
        raise TypeError(
            f"{owner}.{function.__name__}: the first argument is the constants, whatever it is called; "
            f"write def {function.__name__}(c, {', '.join(names)})"
        )
    if not names or unknown:
        hint = did_you_mean(unknown[0], allowed, "the arguments") if unknown else "the first argument is the constants"
        raise TypeError(f"{owner}.{function.__name__}: cannot bind the argument {unknown or names}; {hint}")
    meanings = tuple(meaning_of(name, buffers) for name in names[1:])
    return Behaviour(function, tuple(names[1:]), meanings, _returned(function), reads(function, names[0]))


def reads(function: Callable[..., Any], name: str) -> bool:
    """Return whether a function reads one of its variables.

    From Python 3.13 on one instruction loads or stores two variables.
    """
    for step in dis.get_instructions(function):
        names = step.argval if isinstance(step.argval, tuple) else (step.argval,)
        if (name, "LOAD") in zip(names, re.findall("(LOAD|STORE)_(?:FAST|DEREF|CLOSURE)", step.opname), strict=False):
            return True
    return False


def _returned(function: Callable[..., Any]) -> Any:
    """Annotation of the result, with quoted names resolved, also of fields of a tuple."""
    returns = function.__annotations__.get("return")
    if isinstance(returns, str):
        returns = typing.get_type_hints(function)["return"]
    if hasattr(returns, "_fields") and any(
        isinstance(kind, str | typing.ForwardRef) for kind in returns.__annotations__.values()
    ):
        returns.__annotations__ = typing.get_type_hints(returns)
    return returns
