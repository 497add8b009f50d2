"""Pieces of Markdown that the generated pages are made of."""

from collections.abc import Iterable, Sequence


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


def plain(text: str) -> str:
    """Return text of a docstring as Markdown that shows the same characters."""
    return text.replace("\\", "\\\\").replace("*", "\\*").replace("_", "\\_").replace("<", "\\<").replace("[", "\\[")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
