"""Pages of reports: sections, tables and pictures in one HTML file that needs no network."""

import re
from collections.abc import Iterable, Sequence
from hashlib import blake2b
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from proofmass.runner.output.export import write_whole
from proofmass.runner.output.page_template import PAGE
from proofmass.runner.output.pictures import BLUE, GRID, INK, ORANGE, PAPER, svg_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = {INK: "var(--ink)", GRID: "var(--rule)", PAPER: "none", BLUE: "var(--blue)", ORANGE: "var(--orange)"}
_MARKERS = re.compile(r'(?:<use xlink:href="#\w+" x="[-\d.]+" y="[-\d.]+" (style="[^"]*")/>\s*)(?:<use [^>]*\1/>\s*)+')
_SHORT = 8  # letters of names that need no room to break
_TAG, _DIGITS = re.compile("<[^>]*>"), re.compile(r"(\d\.\d\d)\d+")  # 0.01 point suffices


class LivePart(NamedTuple):
    """Part of a page that moves: HTML with scripts, their styles, and what the page's policy must allow for them."""

    html: str = ""
    styles: str = ""
    policy: str = ""


STILL = LivePart()


def save_page(
    path: str | Path,
    title: str,
    opening: str,
    sections: Iterable[tuple[str, str]],
    footer: str,
    live: LivePart = STILL,
) -> Path:
    """Write a page; opening and the bodies of the sections are HTML already."""
    return write_whole(path, page_text(title, opening, sections, footer, live))


def page_text(
    title: str,
    opening: str,
    sections: Iterable[tuple[str, str]],
    footer: str,
    live: LivePart = STILL,
) -> str:
    """Return a page as text."""
    return PAGE.substitute(
        title=escape(title),
        opening=opening,
        live=live.html,
        styles=live.styles,
        policy=live.policy,
        sections="\n".join(f"<section>\n<h2>{escape(head)}</h2>\n{body}\n</section>" for head, body in sections),
        footer=escape(footer),
    )


def paragraphs(text: str) -> list[str]:
    """Return the paragraphs of a description, escaped."""
    return [escape(part) for part in re.split(r"\n\s*\n", text.strip()) if part]


def picture(figure: "Figure", title: str) -> str:
    """Return a figure as SVG with colours and fonts of the page; the title is read out in its place.

    A page is one document: two pictures with clips of the same name would both be cut by the first,
    so their names have a hash of the drawing. What many markers have in common is said once.
    """
    text = svg_of(figure, **{"svg.fonttype": "none"})
    text = re.sub(r"\bclip_(?=\d)", f"clip_{blake2b(text.encode(), digest_size=6).hexdigest()}_", text)
    head, _, rest = text.partition(">")
    head = head.replace("<svg", '<svg class="picture" role="img"')
    text = f"{head}><title>{escape(title)}</title>{rest}"
    for colour, name in _COLOURS.items():
        text = text.replace(colour, name)
    text = _TAG.sub(lambda tag: _DIGITS.sub(r"\1", tag[0]), _MARKERS.sub(_said_once, text))
    return re.sub(r'(<text[^>]*style=")(?![^"]*fill:)', r"\1fill: var(--ink); ", text)


def _said_once(markers: re.Match[str]) -> str:
    bare = re.sub(rf"\s*{re.escape(markers[1])}/>\s*", "/>", markers[0])
    return f"<g {markers[1]}>{bare}</g>"


def inline(svg: str) -> str:
    """Return an SVG file without the XML head, for use inside a page."""
    return svg[svg.index("<svg") :]


class Html(str):
    """Text that is HTML already."""

    __slots__ = ()


def table(heads: Sequence[str], rows: Iterable[str | Sequence[str]], numbers: Iterable[int] = ()) -> str:
    """Return a table; a row is HTML already, or its cells: texts or `Html`, the first a name unless it is a number."""
    right = set(numbers)
    tags = ['<td class="number">' if i in right else "<td>" if i else "<th>" for i in range(len(heads))]
    rows = list(rows)

    def cells(row: Sequence[str]) -> str:
        texts = (cell if isinstance(cell, Html) else escape(cell) for cell in row)
        return "".join(f"{tag}{text}</{tag[1:3]}>" for tag, text in zip(tags, texts, strict=True))

    top = "".join(f'<th class="number">{h}</th>' if i in right else f"<th>{h}</th>" for i, h in enumerate(heads))
    head = f"<thead><tr>{top}</tr></thead>" if heads else ""
    body = "\n".join(f"<tr>{row if isinstance(row, str) else cells(row)}</tr>" for row in rows)
    short = rows and all(not isinstance(row, str) and row and len(row[0]) <= _SHORT for row in rows)
    opening = '<table class="short">' if short else "<table>"
    return f'<div class="wide">{opening}{head}<tbody>\n{body}\n</tbody></table></div>'


def folded(summary: str, body: str) -> Html:
    """Return HTML that a click unfolds; printed, it is unfolded."""
    return Html(f"<details><summary>{escape(summary)}</summary>\n{body}\n</details>")


def facts(values: Iterable[tuple[str, str]]) -> str:
    """Return a table of names and values without the empty ones."""
    return table((), (f'<th>{escape(k)}</th><td class="long">{escape(v)}</td>' for k, v in values if v))


def broken(name: str) -> Html:
    """Return a name that may break at its dots and underscores."""
    return Html(re.sub("([._])", r"\1<wbr>", escape(name)))


def small(doc: str) -> Html:
    """Return a doc in small letters, names in backquotes as code."""
    return Html("<small>" + re.sub("`([^`]+)`", r"<code>\1</code>", escape(doc)) + "</small>")
