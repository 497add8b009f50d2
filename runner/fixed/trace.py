"""Run a step function once on signals instead of numbers, and keep what it did as a graph of integer operations.

Plain Python works: loops of constant length are unrolled; an `if` on a signal is followed both
ways, by running the function again, and the results are merged by selection. What cannot become
integer code is refused by `TraceError`, which names the line of Python, the range of the value, and
the remedy.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import counting_overflows
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation
from proofmass.runner.fixed.signal import Tracer
from proofmass.runner.fixed.step_formats import Formats, filled, leaves, loader, mantissas, storer


@dataclass(frozen=True)
class Traced:
    """A step function as integer operations."""

    name: str
    arguments: tuple[str, ...]
    formats: Mapping[str, Formats]
    results: Mapping[str, Operation]  # by the text of the result's leaf: "return", "return.total", "return[0]"
    writes: Mapping[str, Operation]  # of buffers: "history[3]"
    overflows: Operation  # how many casts saturated or wrapped
    lost: Operation  # not 0 where a cast saturated or wrapped
    refused: Operation  # not 0 where a cast refused, if that is decided when the code runs
    paths: int
    program: IntegerProgram


def trace(
    function: Callable[..., Any],
    formats: Mapping[str, Formats],
    *,
    refusals: bool = False,
    rests: bool = False,
    program: IntegerProgram | None = None,
) -> Traced:
    """The operations of a step function whose arguments, and "return", have the given formats.

    A cast with the overflow "refuse" is refused here where the value could leave its format; with
    `refusals` it may, and `refused` says in each run of the code whether it did. With `rests` what
    searches by signs leave over are operations, for its slope. Functions traced into one `program`
    share what they have in common: arguments of one name are one value.
    """
    arguments = tuple(inspect.signature(function).parameters)
    unknown = set(arguments).symmetric_difference(set(formats) - {"return"})
    if unknown:
        raise ValueError(f"{function.__name__}: a format for every argument and no other: {', '.join(sorted(unknown))}")
    buffers = [name for name in arguments if isinstance(formats[name], list)]
    tracer = Tracer(function, program or IntegerProgram(rests=rests))

    def run() -> list[Operation]:
        values = {name: loader(formats[name])(filled(formats[name], name, tracer.input)) for name in arguments}
        with counting_overflows(refusals=refusals) as overflows:
            result = function(**values)
        results = []
        for name, value in {"return": result, **{name: values[name] for name in buffers}}.items():
            raw = storer(formats.get(name), name, tracer.storing)(value)
            results += [mantissa for _, mantissa in mantissas(formats.get(name), raw, name)]
        return [tracer.operation(value) for value in (*results, overflows.total, overflows.lost, overflows.refused)]

    operations = tracer.follow(run)
    texts = [text for _, text in leaves(formats.get("return"), "return")]
    written = [text for name in buffers for _, text in leaves(formats[name], name)]
    *values, overflows, lost, refused = operations
    return Traced(
        function.__name__,
        arguments,
        formats,
        dict(zip(texts, values[: len(texts)], strict=True)),
        dict(zip(written, values[len(texts) :], strict=True)),
        overflows,
        lost,
        refused,
        tracer.paths,
        tracer.program,
    )
