"""The graph in Python that `proofmass new sensor.py` writes: it runs, and its largest code is that of the formula."""

import math
import runpy

import pytest

from proofmass.graphs.checks.check import check
from proofmass.graphs.files.library import library_file

FILE = str(library_file("template.toml").with_name("template.py"))


def test_it_prints_the_largest_code(capsys: pytest.CaptureFixture[str]) -> None:
    """m a / k, raised by the resonance, times 3.53e8 V/m; a converter of 16 bits has 2^15 codes for 10 V."""
    runpy.run_path(FILE, run_name="__main__")
    mass, stiffness, omega = 50.43e-9, 49.5627, 2.0 * math.pi * 90.0
    displacement = mass * 9.80665 / (stiffness - mass * omega**2)
    code = displacement * 3.53e8 / 10.0 * 2**15
    words, _, printed = capsys.readouterr().out.strip().rpartition(" ")
    assert words == "largest code:"
    assert int(printed) == pytest.approx(code, rel=2e-3)  # a tick is 1/111 of a period: up to 0.04 % below the peak


def test_its_graph_can_be_imported(capsys: pytest.CaptureFixture[str]) -> None:
    assert check(runpy.run_path(FILE)["graph"]) == []
    assert capsys.readouterr().out == ""
