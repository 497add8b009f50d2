"""Draw every picture of the documents again: `python -m docs.site.pictures`, or `make pictures`.

Names after it draw only those: `python -m docs.site.pictures tuned.png gallery/six_axis_imu.svg`.
"""

import contextlib
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from docs.site.play import play, run_here
from proofmass.graphs.drawing.diagram import svg
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph

DOCS = Path(__file__).parents[1]
PICTURES = DOCS / "pictures"
STEPS = sorted((DOCS / "tutorial").glob("[1-9]-*.md"))
DIAGRAMS = {"sensor.toml": "tutorial_sensor.svg", "loop.toml": "tutorial_loop.svg"}
PLOTS = {"margins.svg": "tutorial_margins.svg", "drift/study.svg": "tutorial_drift.svg"}
GALLERY = {
    f"gallery/{name}.svg": name
    for name in re.findall(r"\(pictures/gallery/(\w+)\.svg\)", (DOCS / "gallery.md").read_text(encoding="utf-8"))
}
OF_THE_LIBRARY = {**GALLERY, "pn_self_test_accelerometer.svg": "pn_self_test_accelerometer"}
COLUMNS = ["--temperature", "thermometer.voltage", "--output", "noisy.output"]
COMMANDS = {  # picture -> words after `proofmass`, and the file that has it then
    "tuned.png": (["tune", "rate_loop.toml", "--samples", "8", "--starts", "1", "--plot", "tuned.png"], "tuned.png"),
    "worst.png": (["worst", "library:margin_tolerance_study", "--plot", "worst.png"], "worst.png"),
    "margin_tolerance.svg": (["montecarlo", "library:margin_tolerance_study", "--out", "margins"], "margins/study.svg"),
    "zero_bias_m1.png": (["fit", "zero_bias_m1.csv", "--plot", "bias.png"], "bias.png"),
    "temperature_compensation_m1.png": (
        ["fit", "temperature_compensation_m1.toml", *COLUMNS, "--plot", "cycle.png"],
        "cycle.png",
    ),
}
FILES = ("zero_bias_m1.csv", "temperature_compensation_m1.toml")  # of the library, which commands take from the folder
PROGRAMS = {  # modules with a `main` of their own
    "docs.noise_pictures": ("noise_quartz.png", "noise_gyroscope.png"),
    "docs.papers.claims_pictures": ("papers_claims.png",),
    "docs.papers.pn_pictures": ("pn_self_calibration.png", "pn_registers.png", "pn_gyroscope.png"),
    "docs.papers.quartz_pictures": ("quartz_calibration.svg", "quartz_recalibration.svg"),
}


def drawings() -> Iterator[tuple[tuple[str, ...], Callable[[], None]]]:
    """Yield names of pictures, by their paths below docs/pictures, and the function that draws these."""
    yield (*DIAGRAMS.values(), *PLOTS.values()), _tutorial
    for picture in OF_THE_LIBRARY:
        yield (picture,), partial(_diagram, picture)
    for picture in COMMANDS:
        yield (picture,), partial(_command, picture)
    for module, pictures in PROGRAMS.items():
        yield pictures, partial(_program, module)


def diagram(picture: str) -> str:
    """Return the diagram of a graph of the library that a picture shows."""
    return svg(read_graph(library_file(f"{OF_THE_LIBRARY[picture]}.toml")))


def _diagram(picture: str) -> None:
    (PICTURES / picture).write_text(diagram(picture), encoding="utf-8")


def _tutorial() -> None:
    """Play the tutorial and take its pictures."""
    for step in STEPS:
        for _ in play(step):
            pass
    for file, picture in DIAGRAMS.items():
        (PICTURES / picture).write_text(svg(read_graph(Path(file))), encoding="utf-8")
    for file, picture in PLOTS.items():
        shutil.copy(file, PICTURES / picture)


def _command(picture: str) -> None:
    """Run a command beside the files of the library and of the page of designs, and take its picture."""
    for name in FILES:
        shutil.copy(library_file(name), name)
    graph = re.search(r"^```toml\n(# rate_loop\.toml\n.*?)^```$", (DOCS / "design_loop.md").read_text(), re.S | re.M)
    Path("rate_loop.toml").write_text(graph[1] if graph else "", encoding="utf-8")
    words, file = COMMANDS[picture]
    status, output = run_here(words)
    if status:
        raise RuntimeError(f"proofmass {' '.join(words)}: exit code {status}\n{output}")
    shutil.copy(file, PICTURES / picture)


def _program(module: str) -> None:
    """Run a module that draws its pictures itself."""
    __import__(module)
    sys.modules[module].main()


def main(wanted: list[str]) -> None:
    """Draw the wanted pictures, or all."""
    for names, draw in drawings():
        if wanted and not set(names) & set(wanted):
            continue
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            draw()
        print(*names, sep="\n", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
