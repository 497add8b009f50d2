"""The diagrams of the gallery in the documents: `python -m tests.documents.pictures` draws them anew."""

import re
from pathlib import Path

from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph

DOCS = Path(__file__).parents[2] / "docs"
PICTURES = re.findall(r"\((pictures/gallery/(\w+)\.svg)\)", (DOCS / "gallery.md").read_text(encoding="utf-8"))


def drawn(name: str) -> str:
    """Return the diagram of a graph of the library."""
    return svg(read_graph(library_file(f"{name}.toml")))


if __name__ == "__main__":
    for path, name in PICTURES:
        (DOCS / path).write_text(drawn(name), encoding="utf-8")
