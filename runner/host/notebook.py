"""Results in notebooks: tables as HTML, and pictures by `plot()`.

Pictures are made on floors above the results; the root package has the table of them, as it has that of public names.
"""

import sys
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Plotted:
    """A result with a picture."""

    def plot(self) -> "Figure":
        """Return the picture as a figure of matplotlib, which notebooks show."""
        figure: Figure = sys.modules["proofmass"].picture_of(self)
        return figure


def html_table(
    heads: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "", below: Iterable[str] = ()
) -> str:
    """Return a table of texts; a cell that begins with "<svg" is a drawing. Lines `below` it are paragraphs."""
    top = "".join(f"<th>{escape(head)}</th>" for head in heads)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(str(cell))}</td>' for cell in row)}</tr>" for row in rows)
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    head = f"<thead><tr>{top}</tr></thead>" if heads else ""
    return f"<table>{title}{head}<tbody>{body}</tbody></table>" + "".join(f"<p>{escape(line)}</p>" for line in below)


def _cell(text: str) -> str:
    return text if text.startswith("<svg ") else escape(text)
