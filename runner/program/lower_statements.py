"""Python statements lowered into statements of a program."""

import ast
from collections.abc import Sequence
from typing import Any

from proofmass.blocks.language.refusals import RefusedError, refuse
from proofmass.runner.program import lower_numbers as numbers
from proofmass.runner.program.build import operand
from proofmass.runner.program.form import INTEGER, Immediate, Kind, Line, Operand, Storage, Variable
from proofmass.runner.program.lower_calls import LoweredCalls
from proofmass.runner.program.lower_expressions import WiderError
from proofmass.runner.program.structure import Lowered, leaves, mapped

_RESULT = "return"


class LoweredStatements(LoweredCalls):
    """Reads statements of one function."""

    changing: frozenset[str] = frozenset()  # names that need variables
    wider: dict[str, Kind]  # kinds of variables and results, as learned before
    result: Lowered = None  # structure of its result, with kinds in place of numbers
    returns = False
    declared: Any = None  # declared result

    def block(self, body: Sequence[ast.stmt]) -> None:
        """Statements one after the other."""
        for node in body:
            if self.builder.ended:
                return
            method = getattr(self, f"_{type(node).__name__.lower()}", None)
            if method is None:
                message, hint = RefusedError.CONSTRUCTS.get(type(node).__name__, (type(node).__name__, "leave it out"))
                raise refuse(node, f"{message} is not compiled", hint)
            self.builder.line = Line(self.function.__code__.co_filename, node.lineno)
            method(node)

    # -- assignments -------------------------------------------------------------------------------

    def _assign(self, node: ast.Assign) -> None:
        value = self.expression(node.value)
        for target in node.targets:
            self.set(target, value)

    def _annassign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            value = self.expression(node.value)
            wanted = {"float": float, "int": int, "bool": bool}.get(ast.unparse(node.annotation))
            self.set(node.target, self._declared(wanted, value))

    def _augassign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Subscript):
            whole, index = self._place(node.target)
            value = self.operated(node, type(node.op), self.builder.load(whole, index), self.number(node.value))
            self.builder.store(whole, index, numbers.as_kind(self.builder, value, whole.entry))
            return
        if not isinstance(node.target, ast.Name):
            raise refuse(node, "a field cannot be changed", "return a new State(...) from update")
        left = self.number(ast.copy_location(ast.Name(node.target.id, ast.Load()), node.target))
        self.set(node.target, self.operated(node, type(node.op), left, self.number(node.value)))

    def set(self, target: ast.expr, value: Lowered) -> None:
        """Assign a value to a target."""
        if isinstance(target, ast.Name):
            self._name_set(target, value)
        elif isinstance(target, ast.Tuple):
            if not isinstance(value, tuple) or len(value) != len(target.elts):
                raise refuse(target, f"{len(target.elts)} variables of something else")
            for part, of in zip(target.elts, value, strict=True):
                self.set(part, of)
        elif isinstance(target, ast.Subscript):
            whole, index = self._place(target)
            self.builder.store(whole, index, numbers.as_kind(self.builder, self._scalar(target, value), whole.entry))
        else:
            raise refuse(target, "a field cannot be changed", "return a new State(...) from update")

    def _place(self, target: ast.Subscript) -> tuple[Storage, Operand]:
        """The list and the index of an entry that is to be changed."""
        whole = self.expression(target.value)
        if not isinstance(whole, Storage):
            raise refuse(target, "it cannot be changed", "declare a Buffer")
        return whole, self.index(whole, self.number(target.slice))

    def _name_set(self, target: ast.Name, value: Lowered) -> None:
        name = target.id
        if name not in self.changing:
            self.names[name] = value
            return
        variable = self.names.get(name)
        if variable is None or name not in self.names:
            count = iter(range(1 << 30))
            self.names[name] = mapped(value, lambda leaf: self._first(f"{name}", next(count), leaf))
            return
        before, after = list(leaves(variable)), list(leaves(value))
        if type(variable) is not type(value) and (isinstance(variable, tuple) or isinstance(value, tuple)):
            raise refuse(target, f"{name} is of another type elsewhere", "take another name")
        for number, (place, part) in enumerate(zip(before, after, strict=True)):
            if isinstance(place, Variable):
                self.builder.set(place, self._fitting(name, number, place.kind, part))
            elif place is not part:
                raise refuse(target, f"{name} is another list elsewhere", "take another name")

    def _first(self, name: str, number: int, leaf: Any) -> Any:
        if isinstance(leaf, Storage):
            return leaf
        kind: Kind = self.wider.get(f"{name} {number}") or leaf.kind
        return self.builder.variable(kind, name, numbers.as_kind(self.builder, leaf, kind))

    def _fitting(self, name: str, number: int, kind: Kind, value: Any) -> Operand:
        """Convert a value to the kind of its variable or result."""
        if numbers.widest(kind, value.kind) is not kind:
            raise WiderError(f"{name} {number}", value.kind)
        return numbers.as_kind(self.builder, value, kind)

    # -- decisions and loops -----------------------------------------------------------------------

    def _if(self, node: ast.If) -> None:
        test = self.test(node.test)
        if isinstance(test, Immediate):
            self.block(node.body if test.value else node.orelse)
            return
        with self.builder.when(test):
            self.block(node.body)
        if node.orelse:
            with self.builder.otherwise():
                self.block(node.orelse)

    def _while(self, node: ast.While) -> None:
        if node.orelse:
            raise refuse(node, "else of a loop", "set a variable before `break`")
        with self.builder.repeated(lambda: self._goes_on(node)):
            self.block(node.body)

    def _goes_on(self, node: ast.While) -> Operand:
        """The condition of a loop; a fault ends it, since after one it might never end."""
        test = self.test(node.test)
        if self.fault is None:
            return test
        return self.builder.compute("both", test, self.builder.compute("not", self.builder.get(self.fault)))

    def _for(self, node: ast.For) -> None:
        if node.orelse:
            raise refuse(node, "else of a loop", "set a variable before `break`")
        if isinstance(node.iter, ast.Call) and isinstance(node.iter.func, ast.Name):
            target = self.expression(node.iter.func)
            if target is range:
                self._counted(node, [self.number(part) for part in node.iter.args])
                return
            if target in (enumerate, zip):
                parts = [self.expression(part) for part in node.iter.args]
                self._over(node, target is enumerate, parts)
                return
        self._over(node, None, [self.expression(node.iter)])

    def _counted(self, node: ast.For, given: Sequence[Operand]) -> None:
        """A loop over a range."""
        whole = [numbers.as_kind(self.builder, value, INTEGER) for value in given]
        first, last, step = (operand(0), *whole, operand(1)) if len(whole) == 1 else (*whole, operand(1))[:3]
        by = numbers.as_index(step)
        if by == 0:
            raise refuse(node, "a range of step 0")
        if by is None:
            self._stepped(node, first, last, step)
            return
        with self.builder.counted(first, last, by, _hint(node.target)) as counter:
            if self.is_natural(first) and (by > 0 or self.is_natural(last)):
                self.natural.add(counter)
            self.set(node.target, counter)
            self.block(node.body)

    def _stepped(self, node: ast.For, first: Operand, last: Operand, step: Operand) -> None:
        """A loop over a range whose step is not known: it counts turns and computes the place."""
        upwards = self.builder.compute("less_integers", 0, step)
        span = self.builder.compute(
            "select",
            upwards,
            self.builder.compute("subtract_integers", last, first),
            self.builder.compute("subtract_integers", first, last),
        )
        size = numbers.absolute(self.builder, step)
        whole = self.builder.compute("add_integers", span, self.builder.compute("subtract_integers", size, 1))
        turns = self.builder.compute("floor_divide", whole, size)
        with self.builder.counted(0, turns) as turn:
            far = self.builder.compute("multiply_integers", turn, step)
            self.set(node.target, self.builder.compute("add_integers", first, far))
            self.block(node.body)

    def _over(self, node: ast.For, numbered: bool | None, parts: Sequence[Lowered]) -> None:
        """A loop over tuples and arrays: `numbered` by enumerate, None for one alone, false for several in step."""
        lengths = [len(part) if isinstance(part, tuple) else getattr(part, "length", None) for part in parts]
        if any(length is None for length in lengths):
            raise refuse(node, "a loop over a value that is not a list", "loops go over range(...), tuples and buffers")
        length = min(lengths)  # type: ignore[type-var]
        if any(isinstance(part, tuple) for part in parts) and not _jumps(node.body):
            for number in range(length):  # type: ignore[arg-type]
                self._turn(node, numbered, parts, operand(number))
            return
        with self.builder.counted(0, length) as counter:  # type: ignore[arg-type]
            self.natural.add(counter)
            self._turn(node, numbered, parts, counter)

    def _turn(self, node: ast.For, numbered: bool | None, parts: Sequence[Lowered], place: Operand) -> None:
        entries = tuple(
            self.builder.load(part, place) if isinstance(part, Storage) else self.entry(node, part, place)
            for part in parts
        )
        value = {None: entries[0], True: (place, entries[0]), False: entries}[numbered]
        self.set(node.target, value)
        self.block(node.body)

    def _pass(self, node: ast.Pass) -> None:
        pass

    def _break(self, node: ast.Break) -> None:
        self.builder.leave()

    def _continue(self, node: ast.Continue) -> None:
        self.builder.next_turn()

    def _expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.expression(node.value)

    # -- the end -----------------------------------------------------------------------------------

    def _return(self, node: ast.Return) -> None:
        value = None if node.value is None else self.expression(node.value)
        value = self._declared(self.declared, value)
        parts = list(leaves(value))
        if any(isinstance(part, Storage) for part in parts):
            raise refuse(node, "a list is returned", "write into one that is given")
        if not self.returns:
            self.returns = True
            count = iter(range(1 << 30))
            self.result = mapped(value, lambda leaf: self.wider.get(f"{_RESULT} {next(count)}", leaf.kind))
        kinds = list(leaves(self.result))
        if len(kinds) != len(parts):
            raise refuse(node, "it returns something else elsewhere")
        values = [
            self._fitting(_RESULT, n, kind, part) for n, (kind, part) in enumerate(zip(kinds, parts, strict=True))
        ]
        self.builder.give(*values, *([self.builder.get(self.fault)] if self.fault else []))

    def _assert(self, node: ast.Assert) -> None:
        raise refuse(node, "assert is not compiled", "leave it out")

    def _raise(self, node: ast.Raise) -> None:
        if hasattr(self.function, "checked"):
            self.note(operand(True))
            return
        raise refuse(node, "raise is not compiled", "return NaN: a number that is not finite ends the run")


def _hint(target: ast.expr) -> str:
    return target.id if isinstance(target, ast.Name) else ""


def _jumps(body: Sequence[ast.stmt]) -> bool:
    """Return whether statements leave the loop around them, or its turn."""
    for node in body:
        if isinstance(node, ast.Break | ast.Continue):
            return True
        if isinstance(node, ast.If) and (_jumps(node.body) or _jumps(node.orelse)):
            return True
    return False
