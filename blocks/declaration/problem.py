"""Problems of a model as data, and their text, written in this one place."""

import difflib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from html import escape
from typing import Any

_LISTED = 12  # names in a hint
_COMPARED = 2000  # names; comparing takes some microseconds each
_OF_UNITS = frozenset("µμΩ°²³·⋅×√")  # letters and signs in units


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One fault of a model: where it is, what was got, what was expected, how to cure it.

    A `note` is worth saying but does not stop a run.

    >>> from proofmass import Problem
    >>> print(Problem(message="unknown key", file="sensor.toml", line=3, key="ratee", hint="did you mean rate?"))
    sensor.toml:3: ratee: unknown key
      hint:     did you mean rate?
    """

    message: str  # what is wrong
    file: str = ""  # "" of a graph from Python
    line: int = 0  # in the file, from 1; 0 where none is known
    key: str = ""  # such as "blocks.adc.bits"; by default the whole path
    got: str = ""  # what was read, as it is written
    expected: str = ""  # what would be right
    hint: str = ""  # how to cure it
    note: bool = False  # True if it does not stop a run
    path: tuple[str, ...] = field(default=(), compare=False)  # keys from the top of the file, to find the line

    def __post_init__(self) -> None:
        if not self.key:
            object.__setattr__(self, "key", ".".join(self.path))

    def at(self, file: str = "", line: int = 0) -> "Problem":
        """Return the problem with its place in a file."""
        return replace(self, file=file or self.file, line=line or self.line)

    def __str__(self) -> str:
        place = ":".join(part for part in (self.file, str(self.line) if self.line else "") if part)
        head = ": ".join(part for part in (place, "note" if self.note else "", self.key, self.message) if part)
        rows = [("got", self.got), ("expected", self.expected), ("hint", self.hint)]
        return "\n".join([_printable(head), *(f"  {name + ':':<9} {_printable(text)}" for name, text in rows if text)])

    @property
    def error(self) -> "ModelError":
        """The error of this problem alone, to be raised."""
        return ModelError([self])

    @property
    def code(self) -> str:
        """The code by which `proofmass explain` tells cause and cure; empty where there is none."""
        # start-up time: most commands refuse nothing
        from proofmass.blocks.declaration.explanations import code_of

        return code_of(self.message)

    def as_data(self) -> dict[str, str | int | bool]:
        """The problem as plain data, for `--json`."""
        names = ("code", "file", "line", "key", "message", "got", "expected", "hint", "note")
        return {name: getattr(self, name) for name in names}


def problems_of_table(*table: str) -> Callable[..., Problem]:
    """Return what makes problems of a table: of a message, the keys below the table, and the other fields."""
    return lambda message, *path, **more: Problem(message=message, path=(*table, *path), **more)


def problem_of_output(node: tuple[str, str], message: str, **more: Any) -> Problem:
    """Return the problem of an output of a graph, by its signal, at the place of its block."""
    return Problem(message=message, key=".".join(node), path=("blocks", node[0]), **more)


class Problems(list[Problem]):
    """Problems in the order in which they were found; a prompt and a notebook show their texts."""

    def __repr__(self) -> str:
        """Return the texts, or that of an empty list."""
        return "\n".join(map(str, self)) or "[]"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self) if self else 'no problems')}</pre>"


class ModelError(ValueError):
    """A model is wrong; `problems` lists every fault that was found.

    >>> from proofmass import Graph, ModelError
    >>> try:
    ...     Graph(name="x", rate="1 kHz", blocks={}, wires=["a.b"])
    ... except ModelError as error:
    ...     print([(problem.key, problem.message) for problem in error.problems])
    [('wires.0', 'not a wire')]
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class Refusal(ValueError):  # noqa: N818  # a word of its own, as in "raise Refusal(...)"
    """The refusal of a value: words that follow its name, what was got and expected, and a cure.

    `key` is the entry of a table that the value stands under.
    """

    def __init__(self, message: str, hint: str = "", *, key: str = "", got: str = "", expected: str = "") -> None:
        super().__init__(message)
        self.hint, self.key, self.got, self.expected = hint, key, got, expected

    def under(self, key: str, value: object, expected: str = "") -> "Refusal":
        """The refusal of a value that stands under a key."""
        return Refusal(str(self), self.hint, key=key, got=shown(value), expected=expected)

    def problem(self, key: str, value: object, *, path: tuple[str, ...] = (), expected: str = "") -> Problem:
        """The refusal as a problem of a model."""
        return Problem(message=str(self), key=key, got=shown(value), expected=expected, hint=self.hint, path=path)


@contextmanager
def under(key: str, value: object, expected: str = "") -> Iterator[None]:
    """Have what refuses a value say under which key it stands."""
    try:
        yield
    except Refusal as error:
        raise error.under(key, value, expected) from None


@contextmanager
def collecting(problems: list[Problem], value: object = None, path: tuple[str, ...] = ()) -> Iterator[None]:
    """Add what is refused to problems, and go on; a refused value stands at a path."""
    try:
        yield
    except ModelError as error:
        problems += error.problems
    except Refusal as error:
        problems.append(error.problem(".".join(path), value, path=path))


def nearest(word: str, names: Iterable[str]) -> str:
    """The valid name most like `word`, or an empty string: "did you mean" for every message.

    >>> nearest("dampign", ["mass", "damping", "stiffness"])
    'damping'
    """
    folded = {_fold(name): name for name in sorted(names, reverse=True)}
    wrong = _fold(word)
    slips = [name for name in folded if _one_slip(wrong, name)]
    swapped = [name for name in slips if sorted(name) == sorted(wrong)]  # letters swapped: nothing is nearer
    found = difflib.get_close_matches(wrong, swapped or slips or folded, n=1, cutoff=0.0 if slips else 0.55)
    return folded[found[0]] if found else ""


def _one_slip(wrong: str, right: str) -> bool:
    """Return whether a letter was dropped, added, replaced or swapped with its neighbour."""
    longer, shorter = (wrong, right) if len(wrong) >= len(right) else (right, wrong)
    if len(shorter) < 2 or len(longer) - len(shorter) > 1:
        return False
    at = next((i for i, (a, b) in enumerate(zip(longer, shorter, strict=False)) if a != b), len(shorter))
    if len(longer) > len(shorter):
        return longer[at + 1 :] == shorter[at:]
    return longer[at + 1 :] == shorter[at + 1 :] or (
        longer[at : at + 2] == shorter[at : at + 2][::-1] and longer[at + 2 :] == shorter[at + 2 :]
    )


def did_you_mean(word: str, names: Iterable[str], what: str, beside: Collection[str] = ()) -> str:
    """A hint: the nearest of the valid names, or the valid names when none is near; `what` is their plural.

    What already stands `beside` the word is meant only where nothing else is near.

    >>> did_you_mean("voltag", ["voltage"], "inputs of adc")
    'did you mean voltage?'
    >>> did_you_mean("x", ["code", "number"], "outputs of adc")
    'outputs of adc: code, number.'
    """
    names = list(names) if isinstance(names, Sequence | Mapping) and len(names) <= _LISTED else sorted(names)
    near = ""
    if len(names) <= _COMPARED:
        near = nearest(word, [name for name in names if name not in beside]) or nearest(word, names)
    if near:
        return f"did you mean {near}?"
    more = [f"and {len(names) - _LISTED} more"] if len(names) > _LISTED else []
    return f"{what}: {', '.join([*names[:_LISTED], *more]) or 'none'}."


def shown(value: object, limit: int = 80) -> str:
    """A value for a message: in ASCII and the signs of units, so that look-alike letters show; one
    line, cut if long.

    >>> print(shown("5 µV/√Hz"), shown("größe"))
    '5 µV/√Hz' 'gr\\xf6\\xdfe'
    """
    try:
        text = repr(value) if not isinstance(value, int) or abs(value) < 10**30 else "an integer of over 30 digits"
    except Exception:  # an integer of thousands of digits in a list, or a foreign object
        text = f"a {type(value).__name__} that cannot be shown"
    start = text[: limit + 1]  # of a million characters the rest is not looked at
    text = "".join(c if c in _OF_UNITS else c.encode("ascii", "backslashreplace").decode("ascii") for c in start)
    return text if len(text) <= limit else text[: limit - 3] + "..."


def _printable(text: str) -> str:
    """Text with what could move a cursor, colour or forge a line written as an escape."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def _fold(name: str) -> str:
    return name.lower().replace("_", "").replace(" ", "")
