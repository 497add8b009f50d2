"""The clock of a netlist placed and routed by nextpnr, and the path that sets it.

Only paths from register to register count: the netlist is placed without its ports, which have no
registers. The path is described by the registers of the Verilog, and by the lines of Python of the
wires on it.
"""

import json
import re
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from proofmass.runner.rtl.tools.programs import found

REGISTER = "register"  # attribute of wires of the netlist that are registers of the Verilog
SEED = 1
_SECONDS = 1800  # a few thousand lookup tables take minutes, on a busy core a quarter of an hour
_DEVICES: Mapping[str, tuple[str, ...]] = {
    "ecp5": ("--45k", "--package", "CABGA381", "--out-of-context"),
    "ice40": ("--up5k", "--package", "sg48"),
}
PLACED = frozenset(_DEVICES)  # families
_FLIP_FLOPS = ("TRELLIS_FF", "SB_DFF")
_NO_PATH = "no path from register to register"
_PACKED = re.compile(r"_(DFFLC|LC)$")  # suffixes of nextpnr for cells that it packs


@dataclass(frozen=True)
class CriticalPath:
    """The slowest path from register to register, the nanoseconds it takes, and lines of Python as "gain.py:41"."""

    source: str
    target: str
    nanoseconds: float
    lines: tuple[str, ...]

    def __str__(self) -> str:
        through = f" ({', '.join(self.lines)})" if self.lines else ""
        return f"from register {self.source} to {self.target}{through}"


@dataclass(frozen=True)
class HighestClock:
    """The highest clock in megahertz and its path, or None; and its origin, or why none is."""

    megahertz: float | None
    told: str
    path: CriticalPath | None = None

    def as_data(self) -> dict[str, Any]:
        """Return plain data."""
        path = {"critical_path": asdict(self.path)} if self.path else {}
        return {"clock_mhz": self.megahertz, "clock_from": self.told} | path

    def __str__(self) -> str:
        path = f" {self.path}" if self.path else ""
        return f"{self.megahertz:.1f} MHz{path}, {self.told}" if self.megahertz else self.told


def routed(folder: Path, netlist: Mapping[str, Any], family: str, verilog: str) -> HighestClock:
    """Place and route a module of Yosys' JSON in a folder, the only one that a sandboxed nextpnr can read.

    `verilog` is its source; `netlist` names lines of it as of module.v.
    """
    cells = {cell["type"] for cell in netlist["cells"].values()}
    if not any(cell.startswith(_FLIP_FLOPS) for cell in cells):
        return HighestClock(None, _NO_PATH)
    if "SB_MAC16" in cells:
        return HighestClock(None, "nextpnr takes multipliers of this family for registers, and finds no clock")
    placer = found(f"nextpnr-{family}", f"yowasp-nextpnr-{family}")
    if placer is None:
        return HighestClock(None, f"pip install yowasp-nextpnr-{family} to have it placed and routed")
    ports = {name: port for name, port in netlist["ports"].items() if name == "clock"}
    module = {**netlist, "ports": ports, "attributes": {"top": "1"}}
    (folder / "placed.json").write_text(json.dumps({"modules": {"module": module}}), encoding="utf-8")
    arguments = ("--json", "placed.json", "--report", "timing.json", "--seed", str(SEED), "--timing-allow-fail")
    command = [placer, *_DEVICES[family], *arguments]
    try:
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=_SECONDS)
    except subprocess.TimeoutExpired:
        return HighestClock(None, f"not routed within {_SECONDS} s")
    if ended.returncode:
        errors = re.findall(r"ERROR: (.*)", ended.stderr)
        return HighestClock(None, f"not placed and routed: {errors[0] if errors else f'exit {ended.returncode}'}")
    timing = json.loads((folder / "timing.json").read_text(encoding="utf-8"))
    conditions = f"{Path(placer).name}{_version(placer)}, seed {SEED}, ports not registered"
    return read_timing(timing, netlist, verilog, conditions)


def read_timing(timing: Mapping[str, Any], netlist: Mapping[str, Any], verilog: str, conditions: str) -> HighestClock:
    """The clock in a report of nextpnr; constant nets may be clocks there too."""
    name = next((name for name in timing["fmax"] if re.fullmatch(r"clock(\$.*)?", name)), "")
    ends = {"from": f"posedge {name}", "to": f"posedge {name}"}
    steps = next((each["path"] for each in timing["critical_paths"] if ends.items() <= each.items()), None)
    if not name or not steps:
        return HighestClock(None, _NO_PATH)
    names = _Registers(netlist)
    path = CriticalPath(
        names.of(steps[0]["from"]["cell"]),
        names.of(steps[-1]["to"]["cell"]),
        round(sum(step["delay"] for step in steps), 3),
        tuple(dict.fromkeys(_lines(steps, verilog.splitlines()))),
    )
    return HighestClock(round(timing["fmax"][name]["achieved"], 2), conditions, path)


class _Registers:
    """The registers of the Verilog by the cells of the netlist that hold them."""

    def __init__(self, netlist: Mapping[str, Any]) -> None:
        self._cells = netlist["cells"]
        self._names: dict[int, str] = {}
        for name, net in netlist["netnames"].items():
            if REGISTER in net["attributes"]:
                self._names |= dict.fromkeys(net["bits"], name)
        self._taken = {
            bit: cell["connections"]["Q"][0]
            for cell in self._cells.values()
            if "Q" in cell["connections"]
            for bit in (*cell["connections"].get("D", ()), *cell["connections"].get("DI", ()))
        }  # output of a flip-flop by its input

    def of(self, cell: str) -> str:
        """Register of a flip-flop, or of the flip-flop packed with a table; otherwise the name of the cell."""
        plain = _PACKED.sub("", cell)
        connections = self._cells.get(plain, {"connections": {}})["connections"]
        bits = connections.get("Q") or [self._taken.get(bit) for bit in connections.get("O", ())]
        return next((self._names[bit] for bit in bits if bit in self._names), plain)


def _lines(steps: list[dict[str, Any]], verilog: list[str]) -> Iterator[str]:
    """Lines of Python from the comments of the Verilog at the wires of a path."""
    for step in steps:
        for source in step.get("sources", ()):
            place = re.match(r"module\.v:(\d+)", source)
            python = place and re.search(r"// (\S+:\d+)", verilog[int(place[1]) - 1])
            if python:
                yield python[1]


@cache
def _version(placer: str) -> str:
    said = subprocess.run([placer, "--version"], capture_output=True, text=True, check=False)
    version = re.search(r"Version nextpnr-([\w.]+)", said.stderr + said.stdout)
    return f" {version[1]}" if version else ""
