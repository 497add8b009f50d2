"""The rules of the typed program, checked before a target reads it: a broken rule is a defect of this package."""

from collections.abc import Iterator, Sequence

from proofmass.runner.program import form
from proofmass.runner.program.walk import statements

_TYPES = {form.FLOAT: float, form.INTEGER: int, form.TRUTH: bool}
_LOWEST, _HIGHEST = -(2**63), 2**63 - 1


class MalformedProgramError(Exception):
    """A program breaks rules of its form; the message names all of them."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


def verify(program: form.Program) -> None:
    """Check every rule of the form; raise `MalformedProgramError` with all that the program breaks."""
    problems = list(_problems(program))
    if problems:
        raise MalformedProgramError(problems)


def _problems(program: form.Program) -> Iterator[str]:
    if not program.functions:
        yield "a program has no function"
        return
    earlier: dict[str, form.Function] = {}
    owners: dict[object, str] = {}
    for name, function in program.functions.items():
        checker = _Checker(function, earlier, owners)
        yield from (f"{name}: {problem}" for problem in checker.problems(name))
        earlier[name] = function
    if len(program.entry.results) > 1:
        yield f"{program.entry.name}: the entry returns {len(program.entry.results)} results; C knows one at most"


class _Checker:
    """Checks one function; `owners` maps every value, variable and array to its function."""

    def __init__(self, function: form.Function, earlier: dict[str, form.Function], owners: dict[object, str]) -> None:
        self.function, self.earlier, self.owners = function, earlier, owners
        self.variables = set(function.variables)
        self.known: set[object] = set()  # what the present statement may read
        self.defined: list[object] = []  # the same in order, by region
        self.loops = 0
        self.line: form.Line | None = None
        self.texts: list[str] = []

    def problems(self, name: str) -> list[str]:
        """Everything wrong with the function."""
        function = self.function
        if function.name != name:
            self._say(f"the function is called {function.name}")
        if not name.isascii() or not name.isidentifier():
            self._say("a function's name consists of letters, digits and underscores")
        for parameter in function.parameters:
            self._define(parameter)
        for variable in function.variables:
            self._own(variable)
        self._region(function.body)
        self.line = None
        if function.results and not _leaves(function.body):
            self._say("the body can end without Return, and the function has results")
        return self.texts

    def _say(self, text: str) -> None:
        self.texts.append(text if self.line is None else f"{text} ({self.line.file}:{self.line.number})")

    # -- definition and use ----------------------------------------------------------------------------------------

    def _own(self, item: "form.Value | form.Variable | form.Storage") -> None:
        if item in self.owners:
            self._say(f"{_named(item)} is defined twice")
        self.owners[item] = self.function.name

    def _define(self, item: "form.Value | form.Storage") -> None:
        self._own(item)
        self.known.add(item)
        self.defined.append(item)

    def _forget(self, count: int) -> None:
        """Leave a region: only the first `count` definitions are known after it."""
        self.known.difference_update(self.defined[count:])
        del self.defined[count:]

    def _use(self, operand: form.Operand, kind: form.Kind | None = None) -> None:
        if isinstance(operand, form.Immediate):
            self._constant(operand)
        elif operand not in self.known:
            self._unknown(operand)
        if kind is not None and operand.kind is not kind:
            self._say(f"{_named(operand)} is {operand.kind.value} where {kind.value} is wanted")

    def _unknown(self, item: "form.Value | form.Storage") -> None:
        where = self.owners.get(item)
        if where is None:
            self._say(f"{_named(item)} is used before it is defined")
        elif where != self.function.name:
            self._say(f"{_named(item)} belongs to {where}")
        else:
            self._say(f"{_named(item)} is used outside of the region that defines it")

    def _constant(self, constant: form.Immediate) -> None:
        value = constant.value
        if type(value) is not _TYPES[constant.kind]:
            self._say(f"a constant of kind {constant.kind.value} holds {value!r}")
        elif constant.kind is form.INTEGER and not _LOWEST <= value <= _HIGHEST:
            self._say(f"64 bits do not hold the constant {value}")

    def _array(self, array: form.Storage) -> None:
        if array not in self.known:
            self._unknown(array)

    def _index(self, array: form.Storage, index: form.Operand, count: int = 1) -> None:
        self._use(index, form.INTEGER)
        if not isinstance(index, form.Immediate) or type(index.value) is not int:
            return
        if index.value < 0 or (array.length is not None and index.value + count > array.length):
            what = f"entry {index.value}" if count == 1 else f"entries {index.value} to {index.value + count - 1}"
            self._say(f"{_named(array)} has no {what}")

    # -- statements ------------------------------------------------------------------------------------------------

    def _region(self, region: form.Region) -> None:
        count = len(self.defined)
        self._statements(region)
        self._forget(count)

    def _statements(self, region: form.Region) -> None:
        for position, statement in enumerate(region):
            self.line = statement.line
            self._statement(statement)
            if isinstance(statement, form.Break | form.Continue | form.Return) and position + 1 < len(region):
                self._say(f"statements stand behind {type(statement).__name__}")

    def _statement(self, statement: form.Statement) -> None:
        match statement:
            case form.Compute():
                self._compute(statement)
            case form.Get(result, variable):
                self._variable(variable, result.kind)
                self._define(result)
            case form.Set(variable, value):
                self._use(value)
                self._variable(variable, value.kind)
            case form.Load(result, array, index):
                self._array(array)
                self._index(array, index)
                self._entry(array, result)
                self._define(result)
            case form.Store(array, index, value):
                self._array(array)
                self._index(array, index)
                self._use(value)
                self._entry(array, value)
                if not array.writable:
                    self._say(f"{_named(array)} is not writable")
            case form.View():
                self._view(statement)
            case form.Call():
                self._call(statement)
            case form.If(condition, then, otherwise):
                self._use(condition, form.TRUTH)
                self._region(then)
                self._region(otherwise)
            case form.For():
                self._for(statement)
            case form.While(test, condition, body):
                count = len(self.defined)
                self._test(test)
                self.line = statement.line
                self._use(condition, form.TRUTH)
                self._loop(body)
                self._forget(count)
            case form.Break() | form.Continue():
                if not self.loops:
                    self._say(f"{type(statement).__name__} stands outside of a loop")
            case form.Return(values):
                self._returned(values)

    def _compute(self, statement: form.Compute) -> None:
        signature = form.OPERATIONS.get(statement.operation)
        if signature is None:
            self._say(f"there is no operation {statement.operation!r}")
        elif len(signature.operands) != len(statement.operands):
            wanted = f"takes {len(signature.operands)} operands, not {len(statement.operands)}"
            self._say(f"{statement.operation} {wanted}")
        else:
            for operand, kind in zip(statement.operands, signature.operands, strict=True):
                self._use(operand, kind)
            free = {o.kind for o, kind in zip(statement.operands, signature.operands, strict=True) if kind is None}
            results = {signature.result} if signature.result else free
            if len(free) > 1:
                self._say(f"the operands of {statement.operation} are of different kinds")
            elif statement.result.kind not in results:
                wanted = next(iter(results)).value
                self._say(f"the result of {statement.operation} is {wanted}, not {statement.result.kind.value}")
        self._define(statement.result)

    def _variable(self, variable: form.Variable, kind: form.Kind) -> None:
        if variable not in self.variables:
            self._say(f"{_named(variable)} is not among the variables of the function")
        if variable.kind is not kind:
            self._say(f"{_named(variable)} is {variable.kind.value}, not {kind.value}")

    def _entry(self, array: form.Storage, value: form.Operand) -> None:
        if array.entry is not value.kind:
            self._say(f"entries of {_named(array)} are {array.entry.value}, not {value.kind.value}")

    def _view(self, statement: form.View) -> None:
        part, whole = statement.part, statement.whole
        self._array(whole)
        self._index(whole, statement.first, part.length or 1)
        if part.entry is not whole.entry:
            self._say(f"entries of {_named(part)} are {part.entry.value}, those of {_named(whole)} {whole.entry.value}")
        if part.writable and not whole.writable:
            self._say(f"{_named(part)} is writable, {_named(whole)} is not")
        if whole.length is not None and part.length is None:
            self._say(f"{_named(part)} has no length, {_named(whole)} has")
        self._define(part)

    def _call(self, statement: form.Call) -> None:
        function = statement.function
        wanted: Sequence[form.Value | form.Storage]
        results: tuple[form.Kind, ...]
        if isinstance(function, form.External):
            name, wanted = function.symbol, [form.Value(kind) for kind in function.parameters]
            results = () if function.result is None else (function.result,)
        else:
            name, wanted, results = function.name, function.parameters, function.results
            if self.earlier.get(name) is not function:
                self._say(f"{name} is not among the functions before this one")
        if len(wanted) != len(statement.arguments):
            self._say(f"{name} takes {len(wanted)} arguments, not {len(statement.arguments)}")
        else:
            for argument, parameter in zip(statement.arguments, wanted, strict=True):
                self._argument(name, argument, parameter)
        if results != tuple(result.kind for result in statement.results):
            told = ", ".join(kind.value for kind in results) or "nothing"
            self._say(f"{name} returns {told}, which is not what the call expects")
        for result in statement.results:
            self._define(result)

    def _argument(self, name: str, argument: form.Operand | form.Storage, parameter: form.Value | form.Storage) -> None:
        if isinstance(parameter, form.Value):
            if isinstance(argument, form.Storage):
                self._say(f"{name} takes a number, not the array {_named(argument)}")
            else:
                self._use(argument, parameter.kind)
        elif not isinstance(argument, form.Storage):
            self._say(f"{name} takes an array for {_named(parameter)}, not {_named(argument)}")
        else:
            self._array(argument)
            if argument.entry is not parameter.entry:
                self._say(f"{name} takes an array of {parameter.entry.value}, not of {argument.entry.value}")
            if parameter.writable and not argument.writable:
                self._say(f"{name} writes to {_named(argument)}, which is not writable")
            if parameter.length is not None and parameter.length != argument.length:
                self._say(f"{name} takes {parameter.length} entries, not the {argument.length} of {_named(argument)}")

    def _for(self, statement: form.For) -> None:
        self._use(statement.first, form.INTEGER)
        self._use(statement.last, form.INTEGER)
        if type(statement.step) is not int or not statement.step or not _LOWEST < statement.step <= _HIGHEST:
            self._say(f"a loop cannot go in steps of {statement.step}")
        if statement.counter.kind is not form.INTEGER:
            self._say(f"the counter {_named(statement.counter)} is {statement.counter.kind.value}, not i64")
        count = len(self.defined)
        self._define(statement.counter)
        self._loop(statement.body)
        self._forget(count)

    def _loop(self, body: form.Region) -> None:
        self.loops += 1
        self._region(body)
        self.loops -= 1

    def _test(self, test: form.Region) -> None:
        loops, self.loops = self.loops, 0
        self._statements(test)
        self.loops = loops
        if any(isinstance(statement, form.Return) for statement in statements(test)):
            self._say("Return stands in the test of a loop")

    def _returned(self, values: tuple[form.Operand, ...]) -> None:
        if len(values) != len(self.function.results):
            self._say(f"Return has {len(values)} values; the function has {len(self.function.results)} results")
            return
        for value, kind in zip(values, self.function.results, strict=True):
            self._use(value, kind)


def _leaves(region: form.Region) -> bool:
    """Return whether a region always ends by Return."""
    last = region[-1] if region else None
    match last:
        case form.Return():
            return True
        case form.If(_, then, otherwise):
            return _leaves(then) and _leaves(otherwise)
        case form.While(_, form.Immediate(_, True), body):
            return not _breaks(body)
        case _:
            return False


def _breaks(region: form.Region) -> bool:
    """Return whether a region can leave the loop around it."""
    for statement in region:
        if isinstance(statement, form.Break):
            return True
        if isinstance(statement, form.If) and (_breaks(statement.then) or _breaks(statement.otherwise)):
            return True
    return False


def _named(item: "form.Operand | form.Variable | form.Storage") -> str:
    if isinstance(item, form.Immediate):
        return f"the constant {item.value!r}"
    what = "array" if isinstance(item, form.Storage) else type(item).__name__.lower()
    return f"{what} {item.name}" if item.name else f"a nameless {what}"
