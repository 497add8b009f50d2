"""Estimate of the longest path of a netlist of the Virtex-II Pro; the delays do not come from a data sheet.

Cell delays are of the order of speed grade -5; a wire between cells takes the same everywhere, but
for carry chains.
"""

from collections.abc import Iterator, Mapping
from typing import Any

_CELLS = {  # nanoseconds, from any input or from one of them
    "LUT": 0.37, "INV": 0.37, "MULT": 4.7, "MUXF": 0.35, "MUXCY.CI": 0.05, "MUXCY.S": 0.41, "MUXCY.DI": 0.35,
    "XORCY.CI": 0.46, "XORCY.LI": 0.30,
}  # fmt: skip
_TO_OUTPUT, _SETUP, _WIRE = 0.45, 0.35, 0.75  # of a flip-flop, and between cells

Netlist = Mapping[str, Any]


def longest_path(netlist: Netlist) -> float:
    """Nanoseconds between registers or ports."""
    cells = netlist["cells"]
    drivers = {
        bit: name
        for name, cell in cells.items()
        for port, bits in cell["connections"].items()
        if cell["port_directions"][port] == "output"
        for bit in bits
    }
    ready = {bit: _TO_OUTPUT for bit, name in drivers.items() if _is_register(cells[name])}
    todo = list(_ends(netlist))
    ends = [bit for bit in todo if isinstance(bit, int)]
    while todo:
        bit = todo[-1]
        if bit in ready or isinstance(bit, str) or bit not in drivers:
            ready.setdefault(bit, 0.0)
            todo.pop()
            continue
        cell = cells[drivers[bit]]
        waiting = [driver for _, driver in _inputs(cell) if driver not in ready]
        if waiting:
            todo += waiting
            continue
        kinds = {driver: cells[drivers[driver]]["type"] if driver in drivers else "" for _, driver in _inputs(cell)}
        ready[bit] = max(
            (ready[driver] + _delay(cell["type"], port, kinds[driver]) for port, driver in _inputs(cell)), default=0.0
        )
    return max((ready[bit] for bit in ends), default=0.0) + _WIRE + _SETUP


def _ends(netlist: Netlist) -> Iterator[int | str]:
    for cell in netlist["cells"].values():
        if _is_register(cell):
            yield from (bit for port, bit in _inputs(cell) if port != "C")
    for port in netlist["ports"].values():
        if port["direction"] == "output":
            yield from port["bits"]


def _inputs(cell: Netlist) -> Iterator[tuple[str, int | str]]:
    for port, bits in cell["connections"].items():
        if cell["port_directions"][port] == "input":
            yield from ((port, bit) for bit in bits)


def _is_register(cell: Netlist) -> bool:
    return str(cell["type"]).startswith("FD")


def _delay(kind: str, port: str, before: str) -> float:
    """Delay of a cell from an input, with the wire to it from a cell of the kind `before`."""
    in_chain = port == "CI" and before == "MUXCY"
    in_slice = kind in ("MUXCY", "XORCY") and port in ("S", "LI") and before.startswith("LUT")
    wire = 0.0 if in_chain or in_slice else _WIRE
    known = _CELLS.get(f"{kind}.{port}")
    if known is None:
        known = next((delay for prefix, delay in _CELLS.items() if kind.startswith(prefix)), _CELLS["LUT"])
    return wire + known
