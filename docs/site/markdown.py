"""Pieces of Markdown that the generated pages are made of."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

_DIAGRAM = re.compile(r'<svg [^>]*class="proofmass[ "][^>]*width="(\d+)"')
_PLOT = re.compile(rb'<svg [^>]*width="([\d.]+)pt"')
_POINT, _DOTS = 96.0 / 72.0, 150.0  # pixels of a point, dots of an inch of a PNG file
_WIDTH_OF_PNG = slice(16, 20)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table; columns that are empty throughout are left out."""
    rows = [[_cell(cell) for cell in row] for row in rows]
    if not rows:
        return []
    used = [column for column in range(len(head)) if any(row[column] for row in rows)]
    lines = ["| " + " | ".join(head[column] for column in used) + " |", "|" + "---|" * len(used)]
    return [*lines, *("| " + " | ".join(row[column] for column in used) + " |" for row in rows), ""]


def code(text: object) -> str:
    """Return text set as code within a line; nothing of nothing."""
    return f"`{text}`" if str(text) else ""


def fence(language: str, text: str) -> list[str]:
    """Return the lines of a fenced block."""
    return [f"```{language}", *text.splitlines(), "```", ""]


def diagram_attributes(picture: str) -> str:
    """Return the attributes of a diagram that `draw` made: its own size in the page; empty for other pictures.

    Its smallest letters have 10 pixels. It scrolls where the page is narrower, and a click shows it alone.

    >>> diagram_attributes('<svg class="proofmass" width="1000" height="9">')
    '{.diagram width=1000px}'
    """
    size = _DIAGRAM.match(picture)
    return f"{{.diagram width={size[1]}px}}" if size else ""


def picture_attributes(path: Path) -> str:
    """Return the attributes of a diagram or a plot: its own size in the page, as of a diagram."""
    data = path.read_bytes()
    if path.suffix == ".png":
        return f"{{.plot width={round(int.from_bytes(data[_WIDTH_OF_PNG]) * _POINT * 72.0 / _DOTS)}px}}"
    size = _PLOT.search(data)
    return f"{{.plot width={round(float(size[1]) * _POINT)}px}}" if size else diagram_attributes(data.decode())


def plain(text: str) -> str:
    """Return text of a docstring as Markdown that shows the same characters."""
    return text.replace("\\", "\\\\").replace("*", "\\*").replace("_", "\\_").replace("<", "\\<").replace("[", "\\[")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
