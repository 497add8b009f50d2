"""Calls of public functions with arguments they do not have: answered by what to write instead."""

from collections.abc import Callable, Mapping
from functools import wraps
from inspect import Parameter, signature
from types import MappingProxyType
from typing import ParamSpec, TypeVar

from proofmass.blocks.declaration.problem import did_you_mean, shown

Arguments = ParamSpec("Arguments")
_Answer = TypeVar("_Answer")

_CHANGED = 'change parameters before: graph.with_parameters({"block.parameter": ...})'
_ELSEWHERE: Mapping[str, tuple[str, ...]] = {  # a name, and what other tools call it
    "duration": ("time", "t_end", "tstop", "stop_time", "length", "seconds", "t", "until"),
    "samples": ("steps", "ticks", "n", "points", "n_steps"),
    "runs": ("n", "count", "trials", "sensors", "samples"),
    "folder": ("out", "output", "path", "directory", "dir"),
    "rate": ("dt", "sample_rate", "fs", "step", "sampling_rate"),
    "wires": ("connections", "edges", "links", "wire"),
    "probes": ("outputs", "record", "signals", "scopes"),
    "blocks": ("nodes", "components"),
    "threads": ("jobs", "workers", "n_jobs", "processes"),
}
_EXAMPLES: Mapping[str, str] = {  # of arguments that must be given
    "name": '"sensor"',
    "blocks": '{"step": Step()}',
    "graph": '"sensor.toml"',
    "study": '"study.toml"',
    "values": '{"block.parameter": [1.0, 2.0]}',
}
_SETS = ("set", "parameters", "params", "values", "changes", "overrides")


def named_arguments(function: Callable[Arguments, _Answer]) -> Callable[Arguments, _Answer]:
    """Return the function with a cure in each error about its arguments."""
    known = MappingProxyType(signature(function).parameters)
    places = [name for name, one in known.items() if one.kind is not Parameter.KEYWORD_ONLY]

    @wraps(function)
    def called(*given: Arguments.args, **named: Arguments.kwargs) -> _Answer:
        if len(given) > len(places):
            raise TypeError(_by_name(function, places, [*known][len(places) :], given))
        for name in named:
            if name not in known:
                raise TypeError(f"{_called(function)} has no argument {name}; {_instead(name, known)}")
        missing = [
            name
            for name, one in [*known.items()][len(given) :]
            if one.default is Parameter.empty and name != "self" and name not in named
        ]
        if missing:
            raise TypeError(_without(function, missing))
        return function(*given, **named)

    return called


def _called(function: Callable[..., object]) -> str:
    return f"{function.__qualname__.removesuffix('.__init__')}()"


def _without(function: Callable[..., object], missing: list[str]) -> str:
    """Return what to add where arguments are missing."""
    written = ", ".join(f"{name}={_EXAMPLES.get(name, '...')}" for name in missing)
    return f"{_called(function)} needs {' and '.join(missing)}: add {written}"


def _instead(name: str, known: Mapping[str, object]) -> str:
    if name in _SETS and "values" not in known:
        return _CHANGED
    meant = next((own for own, others in _ELSEWHERE.items() if own in known and name in others), "")
    return f"did you mean {meant}?" if meant else did_you_mean(name, known, "its arguments")


def _by_name(function: Callable[..., object], places: list[str], rest: list[str], given: tuple[object, ...]) -> str:
    """Return what to write where arguments stand without their names."""
    values = given[len(places) :]
    written = ", ".join(f"{name}={shown(value)}" for name, value in zip(rest, values, strict=False))
    return f"{_called(function)}: these arguments are named: {written}"
