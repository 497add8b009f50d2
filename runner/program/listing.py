"""A program as text for readers, beside the lines of Python that it comes from."""

import linecache
from collections.abc import Iterator
from itertools import chain
from pathlib import PurePath

from proofmass.runner.program import form
from proofmass.runner.program.names import ProgramNames
from proofmass.runner.program.walk import statements, used_once

_INFIX = {
    "add": "+", "subtract": "-", "multiply": "*", "divide": "/", "less": "<", "less_equal": "<=", "equal": "==",
    "not_equal": "!=", "add_integers": "+", "subtract_integers": "-", "multiply_integers": "*", "floor_divide": "//",
    "modulo": "%", "and": "&", "or": "|", "xor": "^", "shift_left": "<<", "shift_right": ">>", "less_integers": "<",
    "less_equal_integers": "<=", "equal_integers": "==", "not_equal_integers": "!=", "both": "and", "either": "or",
    "differ": "!=",
}  # fmt: skip
_PREFIX = {"negate": "-", "not": "not "}
_CALLED = {
    "absolute": "abs", "square_root": "sqrt", "round_half_even": "round", "float_of_integer": "float",
    "integer_of_float": "int", "integer_of_truth": "int", "float_of_truth": "float",
}  # fmt: skip
_LONGEST = 72  # characters of an expression, up to which it contains others
_COLUMN = 88  # where the lines of Python stand


def listing(program: form.Program) -> str:
    """All functions of a program, the entry last."""
    return "\n\n".join("\n".join(_Listed(function).lines()) for function in program.functions.values()) + "\n"


class _Listed:
    """Text of one function; a value that is read once is written inside the expression that reads it."""

    def __init__(self, function: form.Function) -> None:
        self.function = function
        called = {s.function for s in statements(function.body) if isinstance(s, form.Call)}
        self.names = ProgramNames({f.symbol if isinstance(f, form.External) else f.name for f in called})
        self.parts = used_once(function.body)
        self.written: dict[form.Value, str] = {}  # expressions that wait for the statement that reads them
        self.told: form.Line | None = None

    def lines(self) -> Iterator[str]:
        """Head and body."""
        function = self.function
        parameters = ", ".join(f"{self.names[p]}: {_kind(p)}" for p in function.parameters)
        results = ", ".join(kind.value for kind in function.results)
        head = f"{'inline ' if function.inline else ''}def {function.name}({parameters}){results and ' -> ' + results}:"
        yield _beside(head, function.origin)
        body = list(chain(*(self._statement(s) for s in function.body)))
        yield from (f"    {line}" for line in body or ["pass"])

    def _statement(self, statement: form.Statement) -> Iterator[str]:
        if isinstance(statement, form.Compute) and self._waits(statement):
            return
        beside, lines = self._python(statement.line), self._lines(statement)
        for line in lines:
            yield _beside(line, beside, 4)
            beside = ""

    def _waits(self, statement: form.Compute) -> bool:
        """Return whether an operation is written where it is read; keep its text until then."""
        text = self._operation(statement.operation, statement.operands)
        if statement.result not in self.parts or len(text) > _LONGEST:
            return False
        self.written[statement.result] = text if statement.operation not in _INFIX else f"({text})"
        return True

    def _lines(self, statement: form.Statement) -> Iterator[str]:
        match statement:
            case form.Compute(result, operation, operands):
                text = self._operation(operation, operands)
                yield f"{self.names[result]} = {text}"
            case form.Get(result, variable):
                yield f"{self.names[result]} = {self.names[variable]}"
            case form.Set(variable, value):
                yield f"{self.names[variable]} := {self._operand(value)}"
            case form.Load(result, array, index):
                yield f"{self.names[result]} = {self.names[array]}[{self._operand(index)}]"
            case form.Store(array, index, value):
                yield f"{self.names[array]}[{self._operand(index)}] := {self._operand(value)}"
            case form.View(part, whole, first):
                length = "" if part.length is None else f" + {part.length}"
                start = self._operand(first)
                yield f"{self.names[part]} = {self.names[whole]}[{start} : {start}{length}]"
            case form.Call(results, function, arguments):
                yield self._call(results, function, arguments)
            case form.If(condition, then, otherwise):
                yield f"if {self._operand(condition)}:"
                yield from self._region(then)
                if otherwise:
                    yield "else:"
                    yield from self._region(otherwise)
            case form.For(counter, first, last, step, body):
                steps = "" if step == 1 else f", {step}"
                yield f"for {self.names[counter]} in range({self._operand(first)}, {self._operand(last)}{steps}):"
                yield from self._region(body)
            case form.While(test, condition, body):
                yield from self._while(test, condition, body)
            case form.Break():
                yield "break"
            case form.Continue():
                yield "continue"
            case form.Return(values):
                yield f"return {', '.join(map(self._operand, values))}".rstrip()

    def _while(self, test: form.Region, condition: form.Operand, body: form.Region) -> Iterator[str]:
        tested = list(self._region(test)) if test else []
        if not tested:
            yield f"while {self._operand(condition)}:"
        else:
            yield "while True:"
            yield from tested
            yield f"    if not {self._operand(condition)}: break"
        yield from self._region(body)

    def _region(self, region: form.Region) -> Iterator[str]:
        lines = list(chain(*(self._statement(s) for s in region)))
        yield from (f"    {line}" for line in lines or ["pass"])

    def _call(
        self,
        results: tuple[form.Value, ...],
        function: form.Function | form.External,
        arguments: tuple[form.Operand | form.Storage, ...],
    ) -> str:
        name = function.symbol if isinstance(function, form.External) else function.name
        read = ", ".join(self.names[a] if isinstance(a, form.Storage) else self._operand(a) for a in arguments)
        returned = ", ".join(self.names[result] for result in results)
        return f"{returned and returned + ' = '}{name}({read})"

    def _operation(self, operation: str, operands: tuple[form.Operand, ...]) -> str:
        read = [self._operand(operand) for operand in operands]
        if operation in _INFIX:
            return f"{read[0]} {_INFIX[operation]} {read[1]}"
        if operation in _PREFIX:
            return f"{_PREFIX[operation]}{read[0]}"
        if operation == "select":
            return f"({read[1]} if {read[0]} else {read[2]})"
        return f"{_CALLED.get(operation, operation)}({', '.join(read)})"

    def _operand(self, operand: form.Operand) -> str:
        if isinstance(operand, form.Immediate):
            return repr(operand.value)
        return self.written.get(operand) or self.names[operand]

    def _python(self, line: form.Line | None) -> str:
        """The line of Python, if it differs from that of the statement before."""
        if line is None or line == self.told:
            return ""
        self.told = line
        text = linecache.getline(line.file, line.number).strip()
        return f"{PurePath(line.file).name}:{line.number}  {text}".rstrip()


def _kind(item: form.Value | form.Storage) -> str:
    if isinstance(item, form.Value):
        return item.kind.value
    length = "" if item.length is None else item.length
    return f"{'' if item.writable else 'fixed '}{item.entry.value}[{length}]"


def _beside(line: str, remark: str, indent: int = 0) -> str:
    return f"{line:{_COLUMN - indent}}# {remark}" if remark else line
