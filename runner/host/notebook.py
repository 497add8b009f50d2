"""Results at a prompt and in notebooks: a line, a text, tables as HTML, and pictures by `plot()`.

Texts and pictures are made on floors above the results; the root package has the tables of them, as
it has that of public names.
"""

import re
import sys
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from proofmass.blocks.declaration.problem import did_you_mean

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_NUMBER = re.compile(r"[-−+]?[\d.,]+(e[-+]?\d+)?")


class _Answering:
    """A result that answers for attributes it does not have.

    Two are equal if they are one; `digest`, where there is one, tells whether bits are the same.
    """

    def __post_init__(self) -> None:
        """Make arrays read-only, in results that have them so."""

    def __setstate__(self, fields: dict[str, Any]) -> None:
        vars(self).update(fields)
        self.__post_init__()  # NumPy copies and reads back arrays that can be changed

    if not TYPE_CHECKING:  # to checkers of types it has what is declared

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)  # asked for by tools, again and again
            raise AttributeError(f"{type(self).__name__} has no attribute {name!r}; {self._instead(name)}")

    def _instead(self, name: str) -> str:
        """Return a hint at what was meant by an attribute that is not there."""
        known = [attribute for attribute in dir(self) if not attribute.startswith("_")]
        return did_you_mean(name, known, "its attributes")


class Plotted(_Answering):
    """A result with a picture."""

    def plot(self) -> "Figure":
        """Return the picture as a figure of matplotlib, which notebooks show."""
        figure: Figure = sys.modules["proofmass"].picture_of(self)
        return figure


class Told(_Answering):
    """A result with a text for people, that of its command: `repr` is its first line."""

    def __str__(self) -> str:
        text: str = sys.modules["proofmass"].text_of(self)
        return text

    def __repr__(self) -> str:
        """Return the first line of the text."""
        return f"<{type(self).__name__}: {str(self).partition(chr(10))[0]}>"

    def _repr_html_(self) -> str:
        return text_block(str(self))


def text_block(text: str) -> str:
    """Return a text as HTML, its lines as they are."""
    return f'<pre style="font-size: 0.85em; line-height: 1.3; overflow-x: auto">{escape(text)}</pre>'


def html_table(
    heads: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "", below: Iterable[str] = ()
) -> str:
    """Return a table of texts; a cell that begins with "<svg" is a drawing. Lines `below` it are paragraphs."""
    top = "".join(f"<th>{escape(head)}</th>" for head in heads)
    body = "".join(f"<tr>{''.join(_cell(str(cell)) for cell in row)}</tr>" for row in rows)
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    head = f"<thead><tr>{top}</tr></thead>" if heads else ""
    return f"<table>{title}{head}<tbody>{body}</tbody></table>" + "".join(f"<p>{escape(line)}</p>" for line in below)


def _cell(text: str) -> str:
    if text.startswith("<svg "):
        return f"<td>{text}</td>"
    side = "right" if _NUMBER.fullmatch(text) else "left"
    return f'<td style="text-align: {side}; padding-right: 0.8em">{escape(text)}</td>'
