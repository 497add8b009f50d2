"""Signals, on which a step function runs while it is traced: what is done with them becomes operations of a program."""

import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from proofmass.blocks.arithmetic import fixed_point, mantissa, pipeline
from proofmass.blocks.arithmetic.fixed_format import MOST_BITS
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.arithmetic.mantissa import Drop, Mantissa, dropped
from proofmass.runner.fixed.assumptions import Assumptions
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation, SourceLine, TraceError
from proofmass.runner.fixed.operations import OperationName
from proofmass.runner.fixed.step_formats import Format, bounds

MOST_PATHS = 256
USE_WHERE = "write where(condition, a, b) for those that only choose a value"
# No line of these is one of the step's.
_MACHINERY = {module.__file__ for module in (fixed_point, mantissa, pipeline)} | set(
    map(str, Path(__file__).parent.glob("*.py"))
)


def _operators(kind: OperationName) -> tuple[Any, Any]:
    """Return the operator of an operation, and the same with its operands turned round."""
    return lambda self, other: self._made(kind, self, other), lambda self, other: self._made(kind, other, self)


class Signal(Mantissa):
    """A number of a step that is traced: an integer by its operators, an operation of the program by its nature."""

    __slots__ = ("_tracer", "operation")

    def __init__(self, tracer: "Tracer", operation: Operation) -> None:
        self._tracer = tracer
        self.operation = operation

    def _made(self, kind: OperationName, *operands: Any) -> Any:
        """A signal of an operation; what has operators of its own for signals, a FixedValue, comes to its turn."""
        if any(isinstance(operand, FixedValue) for operand in operands):
            return NotImplemented
        return Signal(self._tracer, self._tracer.apply(kind, *map(self._tracer.operation, operands)))

    __add__, __radd__ = _operators("add")
    __sub__, __rsub__ = _operators("subtract")
    __mul__, __rmul__ = _operators("multiply")
    __and__, __rand__ = _operators("and")
    __or__, __ror__ = _operators("or")
    __xor__, __rxor__ = _operators("xor")
    __lt__, __gt__ = _operators("less")
    __le__, __ge__ = _operators("less_equal")
    __eq__, _ = _operators("equal")
    __ne__, _ = _operators("not_equal")
    __hash__ = object.__hash__

    def __neg__(self) -> Any:
        return self._made("negate", self)

    def __abs__(self) -> Any:
        return (self < 0).select(-self, self)

    def __lshift__(self, places: Any) -> Any:
        return self._shifted("shift_left", self, places)

    def __rshift__(self, places: Any) -> Any:
        made = self._shifted("shift_right", self, places)
        if isinstance(places, int) and isinstance(made, Signal) and made.operation.kind == "shift_right":
            error = dropped(lambda mantissa: mantissa >> places), self.operation
            self._tracer.errors.setdefault(made.operation, error)
        return made

    def __rlshift__(self, value: Any) -> Any:
        return self._shifted("shift_left", value, self)

    def __rrshift__(self, value: Any) -> Any:
        return self._shifted("shift_right", value, self)

    def __bool__(self) -> bool:
        return self._tracer.decide(self.operation)

    def _shifted(self, kind: OperationName, value: Any, places: Any) -> Any:
        if isinstance(value, FixedValue):
            return NotImplemented
        low, high = self._tracer.bounds(self._tracer.operation(places))
        if low < 0 or high > MOST_BITS:
            hint = f"bring it to 0 to {MOST_BITS} with clip()"
            self._tracer.refuse("a shift by so many places", got=_interval(low, high), hint=hint)
        return self._made(kind, value, places)

    def __floordiv__(self, divisor: Any) -> Any:
        return self >> self._power_of_two(divisor)

    def __mod__(self, divisor: Any) -> Any:
        return self & ((1 << self._power_of_two(divisor)) - 1)

    def _power_of_two(self, divisor: Any) -> int:
        if not isinstance(divisor, int) or divisor < 1 or divisor & (divisor - 1):
            hint = "divide by a constant power of two, or multiply by a constant reciprocal and shift"
            self._tracer.refuse("a division", got=f"a divisor of {divisor!r}", hint=hint)
        return divisor.bit_length() - 1

    def __truediv__(self, divisor: Any) -> NoReturn:
        hint = "multiply by a constant reciprocal, or shift"
        self._tracer.refuse("a quotient of integers is not an integer", got=repr(self), hint=hint)

    __rtruediv__ = __rfloordiv__ = __rmod__ = __divmod__ = __rdivmod__ = __truediv__

    def __pow__(self, exponent: Any) -> NoReturn:
        self._tracer.refuse("a power", got=repr(self), hint="multiply; a power of two is 1 << places")

    __rpow__ = __pow__

    def __index__(self) -> int:
        hint = "give the loop a constant length with an `if` inside, choose an entry with where()"
        self._tracer.refuse("a signal bounds a loop or indexes a list", got=repr(self), hint=hint)

    __int__ = __index__

    def __float__(self) -> float:
        self._tracer.refuse("a signal in floating point", got=repr(self), hint="stay with integers and FixedValue")

    def __round__(self, digits: int = 0) -> NoReturn:
        self._tracer.refuse("a rounding without a format", got=repr(self), hint="write value.to(format, rounding)")

    def __repr__(self) -> str:
        return f"a signal in {_interval(*self._tracer.bounds(self.operation))}"

    # -- what a mantissa does in a way of its own --------------------------------------------------

    def left_over(self, whole: Any, scale: Any) -> Any:
        """Return 0, an operation of its own in a program that has `rests`."""
        self._tracer.program.searches = True
        return self._made("rest", self, whole, scale) if self._tracer.program.rests else 0

    def select(self, chosen: Any, otherwise: Any) -> "Signal":
        """`chosen` where the signal is not 0, else `otherwise`."""
        a, b = self._tracer.operation(chosen), self._tracer.operation(otherwise)
        return Signal(self._tracer, self._tracer.select(self.operation, a, b))

    def minimum(self, other: Any) -> Any:
        """The smaller of the two."""
        return self._made("minimum", self, other)

    def maximum(self, other: Any) -> Any:
        """The greater of the two."""
        return self._made("maximum", self, other)

    def cut(self) -> "Signal":
        """The signal behind a pipeline cut."""
        return Signal(self._tracer, self._tracer.cut(self.operation))

    def monotone(self, rule: Callable[[Any], Any]) -> "Signal":
        """The value of a rule that never decreases, with the interval of its ends."""
        low, high = self._tracer.bounds(self.operation)
        errors = self._tracer.errors
        before = dict(errors)
        operation = self._tracer.operation(rule(self))
        errors.clear()  # of shifts within a rule the last one drops, by the rule
        errors.update(before)
        if operation.kind == "shift_right":
            errors[operation] = dropped(rule), self.operation
        return Signal(self._tracer, self._tracer.narrowed(operation, rule(low), rule(high)))

    def held(self, low: int, high: int, expected: str) -> "Signal":
        """The signal itself, refused where it could leave the interval."""
        found = self._tracer.bounds(self.operation)
        if found[0] < low or found[1] > high:
            got, wanted = _interval(*found), f"{_interval(low, high)} of {expected}"
            hint = "add .to(format), or clip(value, low, high)"
            self._tracer.refuse(
                "the value does not fit its register", got=got, expected=wanted, hint=hint, place=self.operation.place
            )
        return self


class Tracer:
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
        """Outcome of a condition on this path; if both are possible, the script's, else True."""
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

    def input(self, text: str, format: Format) -> Signal:
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
    def errors(self) -> dict[Operation, tuple[Drop, Operation]]:
        """Bits that shifts drop, and of what."""
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
        while frame.f_code.co_filename in _MACHINERY and frame.f_code is not Tracer.follow.__code__:
            assert frame.f_back is not None, "operations are made inside a trace"
            frame = frame.f_back
        if frame.f_code is Tracer.follow.__code__:
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


def _interval(low: int, high: int) -> str:
    return f"[{low}, {high}]"
