"""Draw the pictures of the tutorial again: python -m docs.site.pictures."""

import contextlib
import shutil
import tempfile
from pathlib import Path

from docs.site.play import play
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.toml_reader import read_graph

DOCS = Path(__file__).parents[1]
STEPS = sorted((DOCS / "tutorial").glob("[1-9]-*.md"))
DIAGRAMS = {"sensor.toml": "tutorial_sensor.svg", "loop.toml": "tutorial_loop.svg"}
PLOTS = {"margins.svg": "tutorial_margins.svg", "drift/study.svg": "tutorial_drift.svg"}


def main() -> None:
    """Play the tutorial in a temporary folder and take its pictures."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for step in STEPS:
            for command in play(step):
                print(command.text)
        for file, picture in DIAGRAMS.items():
            (DOCS / "pictures" / picture).write_text(svg(read_graph(Path(file))), encoding="utf-8")
        for file, picture in PLOTS.items():
            shutil.copy(file, DOCS / "pictures" / picture)
        print(f"wrote {', '.join([*DIAGRAMS.values(), *PLOTS.values()])}")


if __name__ == "__main__":
    main()
