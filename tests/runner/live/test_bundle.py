"""The scripts of a live page: one text without leftovers of modules, and a library as it was published."""

import hashlib
import re
import subprocess
from pathlib import Path

from proofmass.runner.live.bundle import permission, plots, script
from tests.by_hand.live_node import MODULES
from tests.by_hand.node import NODE, needs_node

UPLOT_1_6_32 = {  # of the package on the npm registry
    "uPlot.LICENSE": "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    "uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
}


def test_what_is_vendored_is_as_it_was_published() -> None:
    found = {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in (MODULES / "vendor").iterdir()}
    assert found == UPLOT_1_6_32
    assert "MIT License" in plots()


def test_no_import_or_export_is_left_and_no_text_ends_the_script_early() -> None:
    text = script()
    assert not re.search(r"^(import|export) ", text, re.MULTILINE)
    assert "</script" not in text + plots()
    assert len(text) > sum(file.stat().st_size for file in MODULES.glob("*.mjs")) * 0.95
    assert permission("x") == "'sha256-LXEWQrcmsEQBYnyp+6wy9chTD7GQPMTbAiWHF5IaSIE='"


@needs_node
def test_names_of_modules_do_not_meet(tmp_path: Path) -> None:
    (tmp_path / "whole.js").write_text(script())
    done = subprocess.run(
        [NODE or "", "--check", str(tmp_path / "whole.js")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
