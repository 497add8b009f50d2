"""Tables of text for a terminal."""

from collections.abc import Collection, Sequence


def text_table(rows: Sequence[Sequence[str]], left: Collection[int]) -> list[str]:
    """Return rows of cells as lines; columns whose number is in `left` are aligned left, all others right.

    >>> text_table([("signal", "mean"), ("adc.code", "1.5"), ("dac", "12.25")], left=[0])
    ['signal     mean', 'adc.code    1.5', 'dac       12.25']
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(_padded(row, widths, left)).rstrip() for row in rows]


def _padded(row: Sequence[str], widths: Sequence[int], left: Collection[int]) -> list[str]:
    cells = enumerate(zip(row, widths, strict=True))
    return [cell.ljust(width) if i in left else cell.rjust(width) for i, (cell, width) in cells]
