"""A function of a block as it is registered: what it takes by name and what it returns."""

import dataclasses
import dis
import inspect
import typing
from collections.abc import Callable
from typing import Any

from proofmass.blocks.declaration.problem import did_you_mean


@dataclasses.dataclass(frozen=True)
class Behaviour:
    """A registered function and the names of its arguments after the first."""

    function: Callable[..., Any]
    arguments: tuple[str, ...]
    returns: Any
    reads_constants: bool  # some outputs are a field of the state and nothing else


def behaviour(owner: str, function: Callable[..., Any], known: set[str], values: set[str]) -> Behaviour:
    """Return the behaviour of a function whose arguments after the first are all `known`.

    `values` are names that cannot be that of the first argument, since they stand for what changes from tick to tick.
    """
    names = list(inspect.signature(function).parameters)
    unknown = [name for name in names[1:] if name not in known]
    if names and names[0] in values:
        raise TypeError(
            f"{owner}.{function.__name__}: the first argument is the constants, whatever it is called; "
            f"write def {function.__name__}(c, {', '.join(names)})"
        )
    if not names or unknown:
        hint = did_you_mean(unknown[0], known, "argument") if unknown else "the first argument is the constants"
        raise TypeError(f"{owner}.{function.__name__}: cannot bind the argument {unknown or names}; {hint}")
    reads_constants = any(step.argval == names[0] for step in dis.get_instructions(function))
    return Behaviour(function, tuple(names[1:]), _returned(function), reads_constants)


def _returned(function: Callable[..., Any]) -> Any:
    """The annotation of what is returned, with names in quotes looked up, those of the fields of a tuple too."""
    returns = function.__annotations__.get("return")
    if isinstance(returns, str):
        returns = typing.get_type_hints(function)["return"]
    if hasattr(returns, "_fields") and any(
        isinstance(kind, str | typing.ForwardRef) for kind in returns.__annotations__.values()
    ):
        returns.__annotations__ = typing.get_type_hints(returns)
    return returns
