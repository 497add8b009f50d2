"""Resources of a module in an FPGA: lookup tables, flip-flops and multipliers after synthesis by Yosys.

No open tool places and routes the Virtex-II Pro, `xc2vp`. Its number of slices is a bound, two
lookup tables and two flip-flops in each; its clock is an estimate from the longest path. nextpnr
places and routes ECP5 and iCE40 if it is installed.
"""

import json
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from proofmass.runner.rtl.tools.narrow_products import NARROW, SWAPPED
from proofmass.runner.rtl.tools.path_delay import longest_path
from proofmass.runner.rtl.tools.place_and_route import PLACED, REGISTER, HighestClock, routed
from proofmass.runner.rtl.tools.yosys import run_yosys

ChipFamily = Literal["xc2vp", "xc7", "ice40", "ecp5"]

_COMMANDS: Mapping[ChipFamily, str] = {
    "xc2vp": "synth_xilinx -family xc2vp -flatten -noiopad -noclkbuf -top",
    "xc7": "synth_xilinx -family xc7 -flatten -noiopad -noclkbuf -top",
    "ice40": "synth_ice40 -dsp -top",
    "ecp5": "synth_ecp5 -top",
}
_NARROWEST = 15  # bits of a factor that is worth a multiplier
_NARROW_PRODUCTS = (  # products that become sums, in lookup tables
    "wreduce t:$mul",
    f"techmap -max_iter 1 -map swapped.v t:$mul r:A_WIDTH<{_NARROWEST} %i r:B_WIDTH>={_NARROWEST} %i",
    f"techmap -map narrow.v t:$mul r:B_WIDTH<{_NARROWEST} %i",
    "opt",
)
_KINDS = {  # patterns of cells by kind
    "luts": r"LUT[1-6]|SB_LUT4|INV|SRL.*",
    "flip_flops": r"FD.*|SB_DFF.*|TRELLIS_FF",
    "multipliers": r"MULT18X18.*|DSP48.*|SB_MAC16",
    "carries": r"MUXCY|CARRY4|SB_CARRY|CCU2C",
}


@dataclass(frozen=True)
class Resources:
    """Cells of a module, and its clock."""

    family: str
    luts: int
    flip_flops: int
    multipliers: int
    carries: int
    clock: HighestClock

    @property
    def slices_bound(self) -> int:
        """Least number of slices of two lookup tables and two flip-flops that hold all cells."""
        return -(-max(self.luts, self.flip_flops) // 2)

    def as_data(self) -> dict[str, Any]:
        """Return plain data."""
        counts = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "clock"}
        slices = {"slices_bound": self.slices_bound} if self.family == "xc2vp" else {}
        return counts | slices | self.clock.as_data()

    def __str__(self) -> str:
        slices = f", at least {self.slices_bound} slices" if self.family == "xc2vp" else ""
        cells = f"{self.luts} LUT, {self.flip_flops} FF, {self.multipliers} multipliers, {self.carries} carries"
        return f"{cells}{slices}; clock: {self.clock}"


def synthesized(verilog: str, top: str, family: ChipFamily) -> Resources:
    """Return the resources of the module `top` of a Verilog text; raises `ModelError` for a text that Yosys refuses."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        marked = re.sub(r"^(\s+)reg ", rf"\1(* {REGISTER} *) reg ", verilog, flags=re.MULTILINE)
        (folder / "module.v").write_text(marked)
        (folder / "narrow.v").write_text(NARROW)
        (folder / "swapped.v").write_text(SWAPPED)
        commands = [
            "read_verilog module.v",
            f"hierarchy -check -top {top}",
            "proc",
            "flatten",
            "opt",  # removes registers without effect; kept names survive synthesis
            f"setattr -set keep 1 a:{REGISTER}",
            *_NARROW_PRODUCTS,
        ]
        run_yosys(folder, [*commands, f"{_COMMANDS[family]} {top}", "opt_clean", "write_json netlist.json"])
        netlist = json.loads((folder / "netlist.json").read_text())["modules"][top]
        counts = Counter(cell["type"] for cell in netlist["cells"].values())
        counts_by_kind = {
            kind: sum(n for cell, n in counts.items() if re.fullmatch(pattern, cell))
            for kind, pattern in _KINDS.items()
        }
        if family == "ecp5":  # a carry cell there is two lookup tables
            counts_by_kind["luts"] = counts["LUT4"] + 2 * counts_by_kind["carries"]
            counts_by_kind["multipliers"] = counts["MULT18X18D"]
        return Resources(family=family, clock=_clock(folder, netlist, family, verilog), **counts_by_kind)


def _clock(folder: Path, netlist: Mapping[str, Any], family: ChipFamily, verilog: str) -> HighestClock:
    if family == "xc2vp":
        return HighestClock(1e3 / longest_path(netlist), "an estimate from the longest path, delays not checked")
    if family in PLACED:
        return routed(folder, netlist, family, verilog)
    return HighestClock(None, "nothing is called that places and routes this family")
