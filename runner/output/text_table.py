"""Tables of text for a terminal, as wide as it is."""

import shutil
import sys
import textwrap
from collections.abc import Collection, Iterator, Sequence

_GAP = "  "
_LEAST_TEXT = 24  # characters of a last column of words, from which on it is broken into lines


def text_table(
    rows: Sequence[Sequence[str]], left: Collection[int], width: int | None = None, indent: int = 0
) -> list[str]:
    """Return rows of cells as lines; columns whose number is in `left` are aligned left, all others right.

    A table wider than `width` (of the terminal, if there is one) breaks a last column of words into
    lines, or goes on below with its first column repeated. `indent` is that which a caller puts
    before each line.

    >>> text_table([("signal", "mean"), ("adc.code", "1.5"), ("dac", "12.25")], left=[0])
    ['signal     mean', 'adc.code    1.5', 'dac       12.25']
    >>> text_table([("signal", "mean", "std"), ("dac", "12.25", "0.5")], left=[0], width=14)
    ['signal   mean', 'dac     12.25', '', 'signal  std', 'dac     0.5']
    """
    room = (terminal_width() if width is None else width) - indent
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    last = len(widths) - 1
    if room <= 0 or _across(widths) <= room:
        return _lines(rows, widths, left)
    if last in left and (rest := room - _across(widths[:-1]) - len(_GAP)) >= _LEAST_TEXT:
        return _lines(list(_broken(rows, rest)), [*widths[:-1], rest], left)
    parts = list(_parts(widths, room))
    if len(parts) == 1:
        return _lines(rows, widths, left)
    lines: list[str] = []
    for columns in parts:
        part = [[row[i] for i in columns] for row in rows]
        lines += [""] * bool(lines) + text_table(part, [columns.index(i) for i in columns if i in left], room)
    return lines


def terminal_width() -> int:
    """Return the columns of standard output's terminal, or 0: files and pipes have no width."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else 0


def _across(widths: Sequence[int]) -> int:
    return sum(widths) + len(_GAP) * (len(widths) - 1)


def _parts(widths: Sequence[int], room: int) -> Iterator[list[int]]:
    """Yield the columns of each part: the first one, and as many others as fit."""
    columns = [0]
    for i in range(1, len(widths)):
        if len(columns) > 1 and _across([widths[j] for j in (*columns, i)]) > room:
            yield columns
            columns = [0]
        columns.append(i)
    yield columns


def _broken(rows: Sequence[Sequence[str]], room: int) -> Iterator[list[str]]:
    """Yield rows with the words of the last column in further rows below."""
    for row in rows:
        words = textwrap.wrap(row[-1], room) or [""]
        yield [*row[:-1], words[0]]
        yield from ([*[""] * (len(row) - 1), line] for line in words[1:])


def _lines(rows: Sequence[Sequence[str]], widths: Sequence[int], left: Collection[int]) -> list[str]:
    sides = [f"{{:{'<' if i in left else '>'}{width}}}" for i, width in enumerate(widths)]
    return [_GAP.join(sides).format(*row).rstrip() for row in rows]
