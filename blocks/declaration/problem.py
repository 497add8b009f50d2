"""What is wrong with a model, as data; rendered in this one place."""

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One fault of a model: where it is, what was got, what was expected, how to cure it.

    A `note` is worth saying but does not stop a run.
    """

    message: str
    file: str = ""
    line: int = 0
    key: str = ""
    got: str = ""
    expected: str = ""
    hint: str = ""
    note: bool = False
    path: tuple[str, ...] = field(default=(), compare=False)  # keys from the top of the file, to find the line

    def at(self, file: str = "", line: int = 0) -> "Problem":
        """The same problem with its place in a file."""
        return replace(self, file=file or self.file, line=line or self.line)

    def __str__(self) -> str:
        place = ":".join(part for part in (self.file, str(self.line) if self.line else "") if part)
        head = ": ".join(part for part in (place, "note" if self.note else "", self.key, self.message) if part)
        rows = [("got", self.got), ("expected", self.expected), ("hint", self.hint)]
        return "\n".join([_printable(head), *(f"  {name + ':':<9} {_printable(text)}" for name, text in rows if text)])

    def as_data(self) -> dict[str, str | int | bool]:
        """The problem as plain data, for `--json`."""
        names = ("file", "line", "key", "message", "got", "expected", "hint", "note")
        return {name: getattr(self, name) for name in names}


class ModelError(ValueError):
    """A model is wrong; `problems` lists every fault that was found."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


def nearest(word: str, names: Iterable[str]) -> str:
    """The valid name most like `word`, or an empty string: "did you mean" for every message.

    >>> nearest("dampign", ["mass", "damping", "stiffness"])
    'damping'
    """
    folded = {_fold(name): name for name in sorted(names, reverse=True)}
    found = difflib.get_close_matches(_fold(word), folded, n=1, cutoff=0.55)
    return folded[found[0]] if found else ""


def did_you_mean(word: str, names: Iterable[str], what: str) -> str:
    """A hint that gives the nearest of the valid names, or all of them when none is near."""
    names = sorted(names)
    near = nearest(word, names)
    if near:
        return f"did you mean {near}?"
    if not names:
        return f"there is no {what} here"
    return f"the valid {what}s: {', '.join(names)}" if len(names) > 1 else f"the only {what}: {names[0]}"


def shown(value: object, limit: int = 80) -> str:
    """A value for a message: escaped, one line, cut where it is long."""
    try:
        text = repr(value) if not isinstance(value, int) or abs(value) < 10**30 else "an integer of over 30 digits"
    except Exception:  # an integer of thousands of digits inside a list, or an object of the caller's own
        text = f"a {type(value).__name__} that cannot be shown"
    text = text.encode("ascii", "backslashreplace").decode("ascii")
    return text if len(text) <= limit else text[: limit - 3] + "..."


def _printable(text: str) -> str:
    """Text with whatever could move a cursor, colour a terminal or forge a line written as an escape."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def _fold(name: str) -> str:
    return name.lower().replace("_", "").replace(" ", "")
