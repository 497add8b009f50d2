"""The texts of the built pages as one script, for excerpts of a search in a site that is read from disk."""

import json
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

SCRIPTS = ("texts-of-pages.js", "search-from-disk.js")  # of the page of the search, in this order
_QUIET = {"script", "style", "svg", "nav"}


class _Main(HTMLParser):
    """The text of the part of a page that is its own."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.words: list[str] = []
        self._inside = self._quiet = 0
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "article" and ("role", "main") in attrs:
            self._inside = 1
        self._quiet += tag in _QUIET

    def handle_endtag(self, tag: str) -> None:
        self._inside = 0 if tag == "article" else self._inside
        self._quiet -= tag in _QUIET

    def handle_data(self, data: str) -> None:
        if self._inside and not self._quiet:
            self.words += data.split()


def texts_of_pages(html: Path) -> Iterator[tuple[str, str]]:
    """Yield the name of each built page and its text, words separated by spaces."""
    for page in sorted(html.rglob("*.html")):
        if "_static" not in page.parts:
            yield page.relative_to(html).as_posix(), " ".join(_Main(page.read_text(encoding="utf-8")).words)


def write_texts(html: Path) -> None:
    """Write the script into the built site."""
    texts = json.dumps({name: text for name, text in texts_of_pages(html) if text}, ensure_ascii=False)
    (html / "_static" / SCRIPTS[0]).write_text(f"window.textsOfPages = {texts};\n", encoding="utf-8")
