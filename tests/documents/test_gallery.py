"""The page of the gallery: its pictures are what `draw` makes, and its sensors are those of the library."""

import re

import pytest

from docs.site.gallery import costs, gallery_pages, gallery_pictures
from docs.site.pictures import DOCS, GALLERY, OF_THE_LIBRARY, PICTURES, diagram, drawings
from proofmass import read_graph, simulate
from proofmass.graphs.files.gallery import exhibits
from proofmass.graphs.files.library import library_file, library_files
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten


def test_there_are_pictures() -> None:
    assert len(GALLERY) == 18


@pytest.mark.parametrize("picture", OF_THE_LIBRARY)
def test_a_picture_is_what_draw_makes(picture: str) -> None:
    message = f"python -m docs.site.pictures {picture} draws it anew"
    assert (PICTURES / picture).read_text(encoding="utf-8") == diagram(picture), message


def test_every_picture_can_be_drawn_again_and_is_shown() -> None:
    drawn = [picture for pictures, _ in drawings() for picture in pictures]
    there = {path.relative_to(PICTURES).as_posix() for path in PICTURES.rglob("*") if path.is_file()}
    assert sorted(drawn) == sorted(there)
    pages = "".join(path.read_text(encoding="utf-8") for path in [*DOCS.rglob("*.md"), DOCS.parent / "README.md"])
    assert [picture for picture in drawn if f"pictures/{picture})" not in pages] == []


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    """The pages of the site's gallery, without figures of runs."""
    return dict(gallery_pages(runs=False))


LIBRARY = sorted(path.stem for name, path in library_files().items() if name.endswith(".toml"))


def test_every_graph_of_the_library_is_reached_from_the_index() -> None:
    name, index = next(gallery_pages(runs=False))
    assert name == "gallery/index.md"
    assert sorted(re.findall(r'<a href="../gallery/(\w+).html">', index)) == LIBRARY


@pytest.mark.exhaustive
def test_every_page_has_picture_figures_and_file(pages: dict[str, str]) -> None:
    pictures = dict(gallery_pictures())
    assert sorted(pages) == sorted(f"gallery/{name}.md" for name in [*LIBRARY, "index"])
    for name in LIBRARY:
        page = pages[f"gallery/{name}.md"]
        assert library_file(f"{name}.toml").read_text(encoding="utf-8").strip() in page
        assert "| figure |" in page
        picture = re.search(r"\]\(\.\./pictures/(library/\w+\.svg)\)", page)
        if picture:
            assert pictures[picture[1]].startswith("<svg")
        else:
            assert re.search(r"\| graph \| \[\w+\]", page), "a study shows the graph that it runs"


def test_figures_are_those_of_a_run() -> None:
    page = next(text for name, text in gallery_pages(runs=True, only=("template",)) if name == "gallery/template.md")
    trace = simulate(read_graph("library:template"))["adc.code"]
    assert f"| `adc.code` | `1` | {trace.values.mean():.6g} |" in page


def test_every_graph_that_runs_alone_has_its_time() -> None:
    """Figures of benchmarks/gallery_times.py; the table of the gallery has the same."""
    alone = [item.name for item in exhibits() if not item.study and runs_alone(flatten(read_graph(item.path)))]
    assert sorted(costs()) == sorted(alone)
    assert [name for name, cost in costs().items() if cost >= 1.0] == ["capacitive_readout"]
    rows = re.findall(r"^\| \[.*\]\(#.*\) \|.* ([\d.]+) ms \|$", (DOCS / "gallery.md").read_text("utf-8"), re.MULTILINE)
    assert len(rows) == 17
    assert {float(row) for row in rows} <= {float(f"{1e3 * cost:.2g}") for cost in costs().values()}
    assert f"{len(alone) - 1} of {len(alone)} run faster than real time" in (DOCS / "gallery.md").read_text("utf-8")
