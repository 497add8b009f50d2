"""Pages as Chromium shows them, on a telephone and on a wide screen: whole, within the screen, silent, alone."""

import json
import re
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.output.page import save_page, table
from proofmass.runner.output.report import save_report
from proofmass.runner.studies.shown.report import save_study_report
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.chromium import CHROMIUM, FLAGS
from tests.by_hand.results import mixed_result
from tests.by_hand.study_texts import STUDY

WIDTHS = (400, 1400)
SCRIPT = """
addEventListener("load", () => {
  const seen = [...document.querySelectorAll("iframe")].map(frame => {
    const page = frame.contentDocument.documentElement;
    const sizes = [...page.querySelectorAll("svg, img")].map(picture => picture.getBoundingClientRect());
    return {
      headings: [...page.querySelectorAll("h2")].filter(head => head.offsetHeight).map(head => head.textContent),
      beyond: page.scrollWidth - page.clientWidth,
      pictures: sizes.map(size => [size.width, size.height]),
      clips: [...page.querySelectorAll("clipPath")].map(clip => [clip.id, clip.innerHTML]),
      requests: frame.contentWindow.performance.getEntriesByType("resource").map(entry => entry.name),
    };
  });
  document.body.textContent = JSON.stringify(seen);
});
"""

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")


def seen(pages: list[Path], folder: Path) -> tuple[list[dict[str, Any]], list[str]]:
    """What is on each page at each width, in a frame of one page that asks; and the lines of the console."""
    frames = "".join(
        f'<iframe src="{page.as_uri()}" width="{w}" height="900"></iframe>' for page in pages for w in WIDTHS
    )
    (folder / "frames.html").write_text(f"<!DOCTYPE html><body><script>{SCRIPT}</script>{frames}</body>")
    words = [
        str(CHROMIUM),
        *FLAGS,
        "--dump-dom",
        f"--user-data-dir={folder / 'profile'}",
        (folder / "frames.html").as_uri(),
    ]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=True)
    (found,) = re.findall(r"<body>(\[.*\])</body>", done.stdout)
    return json.loads(unescape(found)), [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@pytest.mark.exhaustive
def test_reports(tmp_path: Path) -> None:
    """Of a study with all sections, and of a run."""
    text = STUDY.replace("seed = 11", 'seed = 11\ndesign = "saltelli"').replace("runs = 6", "runs = 8")
    study = run_study(read_study_text(text), engine="python")
    run = save_report(mixed_result(), tmp_path / "run.html")
    found, console = seen([save_study_report(study, tmp_path / "study.html"), run], tmp_path)
    assert console == []
    study_heads = [
        "Yield",
        "Lifetimes",
        "Measures",
        "Distributions",
        "What scatters them",
        "Sobol indices",
        "Runs to look at",
    ]
    run_heads = ["Block diagram", "Signals", "Traces", "Blocks", "Run", "To repeat it"]
    expected = [[*study_heads, "Study", "To repeat it"], run_heads]
    assert [page["headings"] for page in found] == [heads for heads in expected for _ in WIDTHS]
    assert [page["beyond"] for page in found] == [0] * 4
    assert [page["requests"] for page in found] == [[]] * 4
    assert [len(page["pictures"]) for page in found] == [14, 14, 2, 2]
    assert all(page["clips"] for page in found[2:])
    for page in found:  # the same name is the same clip: otherwise the first of a page would cut all others
        clips = {(name, shape) for name, shape in page["clips"]}
        assert len(clips) == len({name for name, _ in clips})
    assert all(min(size) > 100 for page in found for size in page["pictures"])


def test_a_page_that_is_none_of_this_is_seen(tmp_path: Path) -> None:
    (tmp_path / "bad.html").write_text(
        '<!DOCTYPE html><h2 hidden>Yield</h2><p style="width: 900px">wide</p><img src="http://example.org/x.png">'
        '<svg width="0" height="0"></svg><script>missing()</script>'
    )
    (narrow, wide), console = seen([tmp_path / "bad.html"], tmp_path)
    assert narrow["beyond"] > 400
    assert wide["beyond"] == 0
    for page in (narrow, wide):
        assert page["headings"] == []
        assert page["requests"] == ["http://example.org/x.png"]
        assert [0, 0] in page["pictures"]
    assert "missing is not defined" in console[0]


def test_a_long_path_breaks_and_a_mark_takes_no_room(tmp_path: Path) -> None:
    long = "/".join(["a_folder_with_a_long_name"] * 12)
    rows = [("~", "blocks.adc.bits", "16"), ("+", "measures.noise", "rms")]
    marked = save_page(
        tmp_path / "marks.html", "Differences", f"<p>{long}</p>", [("graph", table(("", "", ""), rows))], ""
    )
    named = table(("", ""), [("a_name_of_a_block", "1"), ("b", "2")])
    assert '<table class="short">' in marked.read_text()
    assert 'class="short"' not in named
    (narrow, _), console = seen([marked], tmp_path)
    assert (narrow["beyond"], console) == (0, [])
