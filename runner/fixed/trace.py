"""Run a step function once on signals instead of numbers, and keep what it did as a graph of integer operations.

Plain Python works: loops of constant length are unrolled; an `if` on a signal is followed both ways, by running the
function again, and the results are merged by selection. What cannot become integer code is refused by `TraceError`,
which names the line of Python, the range of the value, and the remedy.
"""

import inspect
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from proofmass.blocks.arithmetic import fixed_point, mantissa, pipeline
from proofmass.blocks.arithmetic.fixed_point import counting_overflows
from proofmass.runner.fixed import integer_interval, integer_ir, operations, signal, step_formats
from proofmass.runner.fixed.assumptions import Assumptions
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation, SourceLine, TraceError
from proofmass.runner.fixed.operations import OperationName
from proofmass.runner.fixed.signal import Signal
from proofmass.runner.fixed.step_formats import Formats, bounds, filled, leaves, loader, mantissas, storer

MOST_PATHS = 256
USE_WHERE = "write where(condition, a, b) for those that only choose a value"
_MODULES = (fixed_point, mantissa, pipeline, integer_interval, integer_ir, operations, signal, step_formats)
_MACHINERY = {module.__file__ for module in _MODULES} | {__file__}  # no line of these is one of the step's


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
    program: IntegerProgram | None = None,
) -> Traced:
    """The operations of a step function whose arguments, and "return", have the given formats.

    A cast with the overflow "refuse" is refused here where the value could leave its format; with `refusals` it may,
    and `refused` says in each run of the code whether it did. Functions traced into one `program` share what they
    have in common: arguments of one name are one value.
    """
    arguments = tuple(inspect.signature(function).parameters)
    unknown = set(arguments).symmetric_difference(set(formats) - {"return"})
    if unknown:
        raise ValueError(f"{function.__name__}: a format for every argument and no other: {', '.join(sorted(unknown))}")
    buffers = [name for name in arguments if isinstance(formats[name], list)]
    tracer = _Tracer(function, program or IntegerProgram())

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


class _Tracer:
    """One trace: the program under way, and the path through the function's branches that is being followed."""

    def __init__(self, function: Callable[..., Any], program: IntegerProgram) -> None:
        self.program = program
        program.place, program.name = self._place, function.__name__
        self.paths = 0
        self._name = self._key = function.__name__
        code = function.__code__
        self._defined = SourceLine(code.co_filename, code.co_firstlineno)
        self._merging: SourceLine | None = None
        self._assumptions = Assumptions()
        self._script: Sequence[bool] = ()
        self._decisions: list[tuple[Operation, bool]] = []

    def follow(self, run: Callable[[], list[Operation]], script: Sequence[bool] = ()) -> list[Operation]:
        """The results of every path that starts with the outcomes of the script, merged."""
        self.paths += 1
        if self.paths > MOST_PATHS:
            self._refuse_paths()
        self._script, self._decisions, self._key = script, [], self._name
        self._assumptions.clear()
        results = [self._known(operation) for operation in self._run(run)]
        decisions = self._decisions
        self._assumptions.clear()
        for i in range(len(decisions) - 1, len(script) - 1, -1):
            others = self.follow(run, [*(outcome for _, outcome in decisions[:i]), False])
            self._assumptions.clear()
            self._merging = decisions[i][0].place
            results = [self._selected(decisions[i][0], a, b) for a, b in zip(results, others, strict=True)]
            self._merging = None
        return results

    def decide(self, condition: Operation) -> bool:
        """The outcome of a condition on this path; where both are possible, the script's, or else True."""
        low, high = self._assumptions.interval(condition)
        if low > 0 or high < 0 or low == high:
            return low != 0
        if (low, high) != (0, 1):
            condition = self.apply("not_equal", condition, self.program.constant(0))
        if len(self._decisions) >= MOST_PATHS:
            self._refuse_paths()
        i = len(self._decisions)
        outcome = self._script[i] if i < len(self._script) else True
        self._decisions.append((condition, outcome))
        self._assumptions.assume(condition, outcome)
        return outcome

    def input(self, text: str, format: step_formats.Format) -> Signal:
        """The signal of an argument's number."""
        return Signal(self, self.program.input(text, *bounds(format)))

    def storing(self, text: str) -> None:
        """Say which result is looked at, for messages."""
        self._key = f"{self._name}: {text}"

    def operation(self, value: Any) -> Operation:
        """The operation of a signal or of a Python integer."""
        if isinstance(value, Signal):
            return value.operation
        if isinstance(value, int):
            return self.program.constant(int(value))
        hint = "write fixed(value, format, rounding), or make it from a value that is"
        self.refuse(f"a {type(value).__name__} among integers", hint=hint, got=repr(value))

    def apply(self, kind: OperationName, *operands: Operation) -> Operation:
        """An operation on what is known of its operands on this path."""
        return self.program.make(kind, *(self._known(operation) for operation in operands))

    def cut(self, operation: Operation) -> Operation:
        """A pipeline cut: one of a value, whatever is known of it on this path."""
        whole = operation.operands[0] if operation.kind == "narrow" else operation
        return self._known(self.program.make("pipe", whole))

    def select(self, condition: Operation, chosen: Operation, otherwise: Operation) -> Operation:
        """A selection; either value has the interval that it has where it is chosen."""
        return self._selected(self._known(condition), chosen, otherwise)

    def narrowed(self, operation: Operation, low: int, high: int) -> Operation:
        """An operation of which it is known that it lies between two bounds."""
        return self.program.narrow(operation, low, high)

    @property
    def errors(self) -> dict[Operation, float]:
        """The variances of what operations drop, in steps."""
        return self.program.errors

    def bounds(self, operation: Operation) -> tuple[int, int]:
        """The interval of an operation on this path."""
        return self._assumptions.interval(operation)

    def refuse(
        self, message: str, *, hint: str, got: str = "", expected: str = "", place: SourceLine | None = None
    ) -> NoReturn:
        """Raise the error, with the line under way where no other is given."""
        raise TraceError(message, place or self._place(), got=got, expected=expected, hint=hint, key=self._key)

    def _place(self) -> SourceLine:
        """The innermost line of the step function or of what it calls; while results are merged, their condition's."""
        if self._merging:
            return self._merging
        frame = sys._getframe(1)
        while frame.f_code.co_filename in _MACHINERY and frame.f_code is not _Tracer.follow.__code__:
            assert frame.f_back is not None, "operations are made inside a trace"
            frame = frame.f_back
        if frame.f_code is _Tracer.follow.__code__:
            return self._defined
        return SourceLine(frame.f_code.co_filename, frame.f_lineno)

    def _run(self, run: Callable[[], list[Operation]]) -> list[Operation]:
        try:
            return run()
        except TraceError:
            raise
        except (ArithmeticError, AssertionError, LookupError, TypeError, ValueError) as error:
            frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename not in _MACHINERY]
            place = SourceLine(frames[-1].filename, frames[-1].lineno or 0) if frames else self._defined
            text = "an assertion that could fail" if isinstance(error, AssertionError) else str(error)
            message, _, hint = text.partition(": ")
            hint = hint or "a step takes and returns integers and fixed-point values of its formats, and nothing else"
            raise TraceError(message, place, hint=hint, key=self._key) from error

    def _known(self, operation: Operation) -> Operation:
        return self.program.narrow(operation, *self._assumptions.interval(operation))

    def _selected(self, condition: Operation, chosen: Operation, otherwise: Operation) -> Operation:
        with self._assumptions.also(condition, True):
            chosen = self._known(chosen)
        with self._assumptions.also(condition, False):
            otherwise = self._known(otherwise)
        return self.program.make("select", condition, chosen, otherwise)

    def _refuse_paths(self) -> NoReturn:
        place = self._decisions[-1][0].place if self._decisions else None
        hint = f"{USE_WHERE}; a loop that a signal ends is given a constant length"
        raise TraceError(f"more than {MOST_PATHS} paths through the branches", place, hint=hint, key=self._name)
