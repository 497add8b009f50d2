"""A program as text for readers, beside the lines of Python that it comes from."""

import linecache
from collections.abc import Collection, Iterator, Sequence
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
COLUMN = 88  # where the lines of Python stand


def listing(program: form.Program) -> str:
    """All functions of a program, the entry last."""
    return "\n\n".join("\n".join(_listed(function).lines()) for function in program.functions.values()) + "\n"


def _listed(function: form.Function) -> "ListedFunction":
    called = (s.function for s in statements(function.body) if isinstance(s, form.Call))
    return ListedFunction(function, set(map(_name, called)))


class ListedFunction:
    """Text of one function; values read once stand in the expression that reads them."""

    bracketed: Collection[str] = _INFIX  # operations whose texts stand in brackets inside others
    nothing: Sequence[str] = ("    pass",)
    opens, otherwise, closes, ends, always, leaves = ":", "else:", "", "", "True", "if not {}: break"

    def __init__(self, function: form.Function, reserved: Collection[str]) -> None:
        self.function, self.names = function, ProgramNames(reserved)
        self.parts = used_once(function.body)
        self.written: dict[form.Value, str] = {}  # expressions that wait for their readers
        self.told: form.Line | None = None

    def lines(self) -> Iterator[str]:
        """Head and body."""
        function = self.function
        parameters = ", ".join(f"{self.names[p]}: {_kind(p)}" for p in function.parameters)
        results = ", ".join(kind.value for kind in function.results)
        head = f"{'inline ' if function.inline else ''}def {function.name}({parameters}){results and ' -> ' + results}:"
        yield f"{head:{COLUMN}}# {function.origin}" if function.origin else head
        yield from self._region(function.body)

    # -- statements --------------------------------------------------------------------------------

    def _region(self, region: form.Region) -> Sequence[str]:
        return [f"    {line}" for statement in region for line in self._statement(statement)] or self.nothing

    def _statement(self, statement: form.Statement) -> Iterator[str]:
        if isinstance(statement, form.Compute) and self._waits(statement):
            return
        remark = self._python(statement.line)
        for line in self._lines(statement):
            yield self._beside(line, remark) if remark else line
            remark = ""

    def _waits(self, statement: form.Compute) -> bool:
        """Return whether an operation is written where it is read; keep its text until then."""
        text = self._operation(statement)
        if statement.result not in self.parts or len(text) > _LONGEST:
            return False
        self.written[statement.result] = f"({text})" if statement.operation in self.bracketed else text
        return True

    def _lines(self, statement: form.Statement) -> Iterator[str]:
        match statement:
            case form.Compute(result):
                yield self._defined(result, self._operation(statement))
            case form.Get(result, variable):
                yield self._defined(result, self.names[variable])
            case form.Set(variable, value):
                yield self._assigned(self.names[variable], value)
            case form.Load(result, array, index):
                yield self._defined(result, f"{self.names[array]}[{self._operand(index)}]")
            case form.Store(array, index, value):
                yield self._assigned(f"{self.names[array]}[{self._operand(index)}]", value)
            case form.View():
                yield self._view(statement)
            case form.Call():
                yield from self._call(statement)
            case form.If(condition, then, otherwise):
                yield f"if {self._condition(condition)}{self.opens}"
                yield from self._region(then)
                if otherwise:
                    yield self.otherwise
                    yield from self._region(otherwise)
            case form.For():
                yield f"for {self._counted(statement)}{self.opens}"
                yield from self._region(statement.body)
            case form.While():
                yield from self._while(statement)
            case form.Break():
                yield f"break{self.ends}"
            case form.Continue():
                yield f"continue{self.ends}"
            case form.Return(values):
                yield self._returned(values)
        if self.closes and isinstance(statement, form.If | form.For | form.While):
            yield self.closes

    def _while(self, statement: form.While) -> Iterator[str]:
        tested = self._region(statement.test) if statement.test else ()
        if not tested:
            yield f"while {self._condition(statement.condition)}{self.opens}"
        else:
            yield f"while {self.always}{self.opens}"
            yield from tested
            yield f"    {self.leaves.format(self._operand(statement.condition))}"
        yield from self._region(statement.body)

    def _defined(self, result: form.Value, text: str) -> str:
        return f"{self.names[result]} = {text}"

    def _assigned(self, place: str, value: form.Operand) -> str:
        return f"{place} := {self._operand(value)}"

    def _view(self, statement: form.View) -> str:
        part, start = statement.part, self._operand(statement.first)
        length = "" if part.length is None else f" + {part.length}"
        return f"{self.names[part]} = {self.names[statement.whole]}[{start} : {start}{length}]"

    def _call(self, statement: form.Call) -> Iterator[str]:
        returned = ", ".join(self.names[result] for result in statement.results)
        yield f"{returned and returned + ' = '}{_name(statement.function)}({self._arguments(statement)})"

    def _arguments(self, statement: form.Call) -> str:
        return ", ".join(self.names[a] if isinstance(a, form.Storage) else self._alone(a) for a in statement.arguments)

    def _counted(self, statement: form.For) -> str:
        steps = "" if statement.step == 1 else f", {statement.step}"
        first, last = self._operand(statement.first), self._operand(statement.last)
        return f"{self.names[statement.counter]} in range({first}, {last}{steps})"

    def _returned(self, values: Sequence[form.Operand]) -> str:
        return f"return {', '.join(map(self._alone, values))}".rstrip()

    # -- expressions -------------------------------------------------------------------------------

    def _operation(self, statement: form.Compute) -> str:
        operation, read = statement.operation, [self._operand(operand) for operand in statement.operands]
        if operation in _INFIX:
            return f"{read[0]} {_INFIX[operation]} {read[1]}"
        if operation in _PREFIX:
            return f"{_PREFIX[operation]}{read[0]}"
        if operation == "select":
            return f"({read[1]} if {read[0]} else {read[2]})"
        return f"{_CALLED.get(operation, operation)}({', '.join(read)})"

    def _operand(self, operand: form.Operand) -> str:
        if isinstance(operand, form.Immediate):
            return self._number(operand.value)
        return self.written.get(operand) or self.names[operand]

    def _alone(self, operand: form.Operand) -> str:
        """An operand that stands between commas."""
        return self._operand(operand)

    def _condition(self, operand: form.Operand) -> str:
        return self._operand(operand)

    def _number(self, value: float | int | bool) -> str:
        return repr(value)

    def _python(self, line: form.Line | None) -> str:
        """The line of Python, if it differs from that of the statement before."""
        if line is None or line == self.told:
            return ""
        self.told = line
        text = linecache.getline(line.file, line.number).strip()
        return f"{PurePath(line.file).name}:{line.number}  {text}".rstrip()

    def _beside(self, line: str, remark: str) -> str:
        return f"{line:{COLUMN - 4}}# {remark}"


def _name(function: form.Function | form.External) -> str:
    return function.symbol if isinstance(function, form.External) else function.name


def _kind(item: form.Value | form.Storage) -> str:
    if isinstance(item, form.Value):
        return item.kind.value
    length = "" if item.length is None else item.length
    return f"{'' if item.writable else 'fixed '}{item.entry.value}[{length}]"
