"""Staging: every page of the repository at its place in the site, its links rewritten, the reference beside it."""

import os
import re
import shutil
import tomllib
from pathlib import Path, PurePosixPath

from docs.site.alive import live_page, with_frame
from docs.site.gallery import THUMBNAILS, all_exhibits, cards, gallery_pages, gallery_pictures
from docs.site.markdown import picture_attributes
from docs.site.reference import contents, reference_pages

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
HERE = Path(__file__).parent
FRONT = {  # pages outside docs/, and the landing page, by their names in the site
    "docs/README.md": "index.md",
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CLAIMS.md": "claims.md",
    "KNOWN_GAPS.md": "known-gaps.md",
    "SECURITY.md": "security.md",
}
_ALL_GRAPHS = (
    "\n## All others\n\n[All graphs of the library](gallery/index.md) have pages with picture, figures and file.\n"
)
_CARDS = "<!-- cards -->"  # where the page of the gallery has its sensors as pictures
_LINK = re.compile(r"(\]\()([^)#\s]+)(#[^)\s]*)?(\))")
_FENCE = re.compile(r"^(```.*?^```)$", re.DOTALL | re.MULTILINE)
_ALONE = ("reference/blocks/", "gallery/", "decisions/")  # pages that an index of their own lists
_INDEXES = ("reference/blocks/index", "gallery/index", "decisions/README")


class BrokenLinkError(Exception):
    """A page links to what is not there."""


def stage(target: Path, *, runs: bool = False) -> list[str]:
    """Write the source of the site to a folder and return the names of its pages.

    With `runs` the graphs of the library and the examples of blocks are run, and their pages have figures and pictures.
    """
    shutil.rmtree(target, ignore_errors=True)
    pages = {_place(path): path for path in repository_pages()}
    for name, path in pages.items():
        _write(target / name, _rewritten(path, name, target))
    for name, text in (*reference_pages(runs), *gallery_pages(runs=runs)):
        _write(target / name, text)
    names = sorted(path.relative_to(target).as_posix() for path in target.rglob("*.md"))
    index = target / "index.md"
    index.write_text(with_frame(index.read_text(encoding="utf-8")) + "\n" + _toctrees(names), encoding="utf-8")
    live_page(target / "extra")
    shutil.copytree(DOCS / "pictures", target / "pictures")
    for name, text in gallery_pictures():
        _write(target / "pictures" / name, text)
        _write(target / "extra" / THUMBNAILS / Path(name).name, text)
    shutil.copytree(HERE / "static", target / "static")
    shutil.copy(HERE / "conf.py", target / "conf.py")
    return names


def repository_pages() -> list[Path]:
    """Return the pages that people write: those of docs/, and some beside it."""
    front = [ROOT / name for name in FRONT if name != "README.md" and (ROOT / name).exists()]
    return sorted({*front, *DOCS.rglob("*.md")})


def sections() -> list[dict[str, object]]:
    """Return the sections of the navigation, in order."""
    return list(tomllib.loads((HERE / "nav.toml").read_text(encoding="utf-8"))["section"])


def navigation(names: list[str]) -> dict[str, list[str]]:
    """Return the pages of each section by its caption: those named, then those of its folder, then the rest."""
    left = {name.removesuffix(".md") for name in names} - {"index"}
    left = {page for page in left if not page.startswith(_ALONE) or page in _INDEXES}
    tree: dict[str, list[str]] = {}
    for section in sections():
        pages = [page for page in section["pages"] if page in left]
        pages += sorted(page for page in left - set(pages) if page.startswith(f"{section['folder']}/"))
        tree[str(section["caption"])] = pages
        left -= set(pages)
    rest = next(str(section["caption"]) for section in sections() if section.get("rest"))
    tree[rest] += sorted(left)
    return {caption: pages for caption, pages in tree.items() if pages}


def _toctrees(names: list[str]) -> str:
    """Return the navigation as hidden tables of contents of the landing page."""
    return "\n".join(
        "\n".join(["```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```", ""])
        for caption, pages in navigation(names).items()
    )


def _place(path: Path) -> str:
    name = path.relative_to(ROOT).as_posix()
    return FRONT.get(name, name.removeprefix("docs/"))


def _rewritten(path: Path, name: str, target: Path) -> str:
    """Return the text of a page with the links that hold in the site; pages that list others get their lists."""
    text = "".join(
        piece if piece.startswith("```") else _LINK.sub(lambda link: _moved(link, path, name, target), piece)
        for piece in _FENCE.split(path.read_text(encoding="utf-8"))
    )
    if name == "reference/index.md":
        text += "\n" + contents()
    if name == "gallery.md":
        shown = dict.fromkeys(re.findall(r"library:(\w+)", text))
        text = text.replace(_CARDS, "\n".join(cards([item for item in all_exhibits() if item.name in shown], "")))
        text += _ALL_GRAPHS
    if name == "decisions/README.md":
        text += "\n```{toctree}\n:hidden:\n:glob:\n\n0*\n```\n"
    return text


def _moved(link: re.Match[str], path: Path, name: str, target: Path) -> str:
    start, address, anchor, end = link[1], link[2], link[3] or "", link[4]
    if "://" in address or address.startswith("mailto:"):
        return link[0]
    there = (path.parent / address).resolve()
    if not there.exists():
        raise BrokenLinkError(f"{path.relative_to(ROOT)}: {address}")
    if there.is_dir():
        there /= "README.md"
    if _is_page(there):
        return start + _relative(_place(there), name) + anchor + end
    if there.is_relative_to(DOCS / "pictures"):
        place = _relative(f"pictures/{there.relative_to(DOCS / 'pictures').as_posix()}", name)
        return start + place + end + picture_attributes(there)
    place = f"files/{there.relative_to(ROOT).as_posix()}"
    (target / place).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(there, target / place)
    return start + _relative(place, name) + end


def _is_page(path: Path) -> bool:
    """Return whether a file of the project is a page of the site."""
    return path.suffix == ".md" and (path.is_relative_to(DOCS) or path.relative_to(ROOT).as_posix() in FRONT)


def _relative(place: str, page: str) -> str:
    return PurePosixPath(os.path.relpath(place, PurePosixPath(page).parent)).as_posix()


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
