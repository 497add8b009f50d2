"""The closed loop of the tutorial as a page that carries the engine: the landing page shows it."""

import contextlib
import io
import re
import shutil
import tempfile
from pathlib import Path

from proofmass.runner.command_line import main

STEP = Path(__file__).parents[1] / "tutorial" / "3-close-the-loop.md"
NAME = "closed-loop.html"
FRAME = f"""
This sensor is alive: the page carries the compiled loop. Drag *integral*, the gain of its controller: the traces
below follow. The SHA-256 is the one that `proofmass run` prints.

```{{raw}} html
<iframe class="alive" src="{NAME}#controller" title="A closed-loop accelerometer with sliders" loading="lazy"></iframe>
<p><a href="{NAME}">Open it on a page of its own</a></p>
```
"""


def live_page(folder: Path) -> None:
    """Write the page into a folder."""
    graph = re.findall(r"^```toml\n(.*?)^```$", STEP.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[0]
    with tempfile.TemporaryDirectory() as work, contextlib.chdir(work), contextlib.redirect_stdout(io.StringIO()):
        Path("loop.toml").write_text(graph, encoding="utf-8")
        status = main(["run", "loop.toml", "--out", "results", "--live", "--quiet"])
        if status:
            raise RuntimeError(f"the loop of {STEP.name} does not run: exit code {status}")
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy("results/report.html", folder / NAME)


def with_frame(page: str) -> str:
    """Return a page with the live sensor after its first picture."""
    return re.sub(
        r"^(!\[.*\]\(.*\)(?:\{.*\})?)$", lambda picture: picture[1] + "\n" + FRAME, page, count=1, flags=re.MULTILINE
    )
