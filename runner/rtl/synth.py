"""What a module takes in an FPGA: lookup tables, flip-flops and multipliers after synthesis by Yosys.

`xc2vp` is the Virtex-II Pro, which nothing open places and routes: its slices are a bound, two lookup tables and two
flip-flops in each, and its clock is an estimate from the longest path. ECP5 and iCE40 are placed and routed by nextpnr
where it is installed.
"""

import json
import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from proofmass.runner.rtl.narrow_products import NARROW, SWAPPED
from proofmass.runner.rtl.path_delay import longest_path
from proofmass.runner.rtl.yosys import run_yosys

Family = Literal["xc2vp", "xc7", "ice40", "ecp5"]

_COMMANDS: Mapping[Family, str] = {
    "xc2vp": "synth_xilinx -family xc2vp -flatten -noiopad -noclkbuf -top",
    "xc7": "synth_xilinx -family xc7 -flatten -noiopad -noclkbuf -top",
    "ice40": "synth_ice40 -dsp -top",
    "ecp5": "synth_ecp5 -top",
}
_NARROWEST = 15  # bits of a factor that is worth a multiplier
_NARROW_PRODUCTS = (  # become sums, in lookup tables
    "wreduce t:$mul",
    f"techmap -max_iter 1 -map swapped.v t:$mul r:A_WIDTH<{_NARROWEST} %i r:B_WIDTH>={_NARROWEST} %i",
    f"techmap -map narrow.v t:$mul r:B_WIDTH<{_NARROWEST} %i",
    "opt",
)
_KINDS = {  # of cells, by what they are
    "luts": r"LUT[1-6]|SB_LUT4|INV|SRL.*",
    "flip_flops": r"FD.*|SB_DFF.*|TRELLIS_FF",
    "multipliers": r"MULT18X18.*|DSP48.*|SB_MAC16",
    "carries": r"MUXCY|CARRY4|SB_CARRY|CCU2C",
}
_PLACERS: Mapping[str, tuple[str, ...]] = {
    "ecp5": ("--45k", "--package", "CABGA381", "--out-of-context"),
    "ice40": ("--up5k", "--package", "sg48"),
}
_SECONDS = 500  # for place and route
SEED = 1


@dataclass(frozen=True)
class Resources:
    """Cells of a module; the clock in megahertz, and where that comes from."""

    family: str
    luts: int
    flip_flops: int
    multipliers: int
    carries: int
    clock_mhz: float | None
    clock_from: str

    @property
    def slices_bound(self) -> int:
        """The fewest slices of two lookup tables and two flip-flops that hold them."""
        return -(-max(self.luts, self.flip_flops) // 2)

    def as_data(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self) | ({"slices_bound": self.slices_bound} if self.family == "xc2vp" else {})

    def __str__(self) -> str:
        clock = f"{self.clock_mhz:.1f} MHz, {self.clock_from}" if self.clock_mhz else self.clock_from
        slices = f", at least {self.slices_bound} slices" if self.family == "xc2vp" else ""
        cells = f"{self.luts} LUT, {self.flip_flops} FF, {self.multipliers} multipliers, {self.carries} carries"
        return f"{cells}{slices}; clock: {clock}"


def synthesized(verilog: str, top: str, family: Family) -> Resources:
    """The resources of the module `top` of a Verilog text; raises `ModelError` for what Yosys refuses."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "module.v").write_text(verilog)
        (folder / "narrow.v").write_text(NARROW)
        (folder / "swapped.v").write_text(SWAPPED)
        commands = [
            "read_verilog module.v",
            f"hierarchy -check -top {top}",
            "proc",
            "flatten",
            "opt",
            *_NARROW_PRODUCTS,
        ]
        run_yosys(folder, [*commands, f"{_COMMANDS[family]} {top}", "opt_clean", "write_json netlist.json"])
        netlist = json.loads((folder / "netlist.json").read_text())["modules"][top]
        counts = Counter(cell["type"] for cell in netlist["cells"].values())
        found = {
            kind: sum(n for cell, n in counts.items() if re.fullmatch(pattern, cell))
            for kind, pattern in _KINDS.items()
        }
        if family == "ecp5":  # a carry cell there is two lookup tables
            found["luts"] = counts["LUT4"] + 2 * found["carries"]
            found["multipliers"] = counts["MULT18X18D"]
        clock: float | None
        if family == "xc2vp":
            clock, told = 1e3 / longest_path(netlist), "an estimate from the longest path, delays not checked"
        else:
            clock, told = _routed(folder, family)
        return Resources(family=family, clock_mhz=clock, clock_from=told, **found)


def _routed(folder: Path, family: str) -> tuple[float | None, str]:
    """The clock that nextpnr finds; its netlist is named from its own folder, as its sandboxed build wants it."""
    if family not in _PLACERS:
        return None, "nothing open places and routes this family"
    placer = shutil.which(f"nextpnr-{family}") or shutil.which(f"yowasp-nextpnr-{family}")
    if placer is None:
        return None, f"pip install yowasp-nextpnr-{family} to have it placed and routed"
    arguments = [placer, *_PLACERS[family], "--json", "netlist.json", "--seed", str(SEED), "--timing-allow-fail"]
    try:
        ended = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False, timeout=_SECONDS)
    except subprocess.TimeoutExpired:
        return None, f"not routed within {_SECONDS} s"
    found = re.findall(r"Max frequency for clock.*?: ([0-9.]+) MHz", ended.stderr)
    if not found:
        return None, "nextpnr names no path from register to register"
    told = f"{Path(placer).name}, seed {SEED}, from register to register"
    return float(found[-1]), told
