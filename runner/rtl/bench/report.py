"""The report beside the Verilog: ports, registers, latency and cost, as JSON and as one HTML file.

Callers pass the results of simulators, proofs and synthesis, by the name of what was simulated,
proved or counted.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import Any

from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import write_rate
from proofmass.runner.host.versions import PROOFMASS
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.page import broken, facts, paragraphs, save_page, small, table
from proofmass.runner.rtl.bench.cost import machine_cost, module_cost
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.words import VerilogPort
from proofmass.runner.rtl.text.machine_verilog import top_name
from proofmass.runner.run.provenance import graph_hash

_COSTS = {
    "register_bits": "register bits",
    "pipeline_bits": "pipeline bits",
    "adder_bits": "adder bits",
    "comparator_bits": "comparator bits",
    "multiplexer_bits": "multiplexer bits",
    "multipliers": "multipliers",
    "constant_multipliers": "by constants",
}


_FOUND = {
    "simulations": "Simulations",
    "proofs": "Proofs",
    "resources": "Resources",
}  # sections of results that callers pass


def report_data(
    graph: Graph, machine: Machine, vectors: int, resources: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, Any]:
    """The report as plain data; `vectors` are the clocks of the test bench, `resources` is by the keys of `_FOUND`."""
    data = {
        "graph": graph.name,
        "graph_hash": graph_hash(graph),
        "proofmass": PROOFMASS,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "top": top_name(machine),
        "clock_hz": float(machine.rate),
        "clock": write_rate(machine.rate),
        "latency": machine.latency,
        "vectors": vectors,
        "inputs": [_port(port) for port in machine.inputs],
        "outputs": [_port(port) for port in machine.outputs],
        "instances": [
            {
                "block": instance.path,
                "module": instance.module.name,
                "clocks_per_tick": instance.stride,
                "ticks_late": instance.stage,
            }
            for instance in machine.instances
        ],
        "modules": [_module(module) for module in machine.modules],
        "cost": machine_cost(machine).as_data(),
    }
    return data | dict(resources or {})


def save_report(graph: Graph, data: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write report.json and report.html into a folder."""
    text = write_whole(folder / "report.json", json.dumps(data, indent=2) + "\n")
    sections = [
        ("Ports", _ports([("in", data["inputs"]), ("out", data["outputs"])])),
        ("Blocks", _blocks(data)),
        *((f"Module {module['name']}", _module_page(module)) for module in data["modules"]),
        *((head, _found(data[key])) for key, head in _FOUND.items() if key in data),
    ]
    opening = [*paragraphs(graph.description), escape(_summary(data))]
    footer = f"proofmass {data['proofmass']}, {data['date']}, graph {data['graph_hash'][:12]}"
    page = save_page(
        folder / "report.html",
        f"Hardware of {graph.name}",
        "".join(f"<p>{text}</p>\n" for text in opening),
        sections,
        footer,
    )
    return [text, page]


def cost_text(cost: Mapping[str, Any]) -> str:
    """The cost in one line: "381 register bits, 1273 adder bits, multipliers 32 x 24 (2)"; zeros are left out."""
    parts = [f"{cost[key]} {_COSTS[key]}" for key in ("register_bits", "pipeline_bits", "adder_bits")]
    parts = [part for part in parts if not part.startswith("0 ")]
    for key in ("multipliers", "constant_multipliers"):
        if cost[key]:
            parts.append(f"{_COSTS[key]} {_shapes(cost[key])}")
    return ", ".join(parts) or "wires alone"


def _port(port: VerilogPort) -> dict[str, Any]:
    word = port.word
    return {
        "name": port.name,
        "signal": port.text,
        "format": str(word),
        "width": word.width,
        "fraction": word.fraction,
        "signed": word.signed,
        "lowest": word.low,
        "highest": word.high,
        "unit": port.unit,
        "doc": port.doc,
    }


def _module(module: Module) -> dict[str, Any]:
    return {
        "name": module.name,
        "kind": type(module.block).__name__,
        "latency": module.pipeline.latency,
        "parameters": {name: str(getattr(module.block, name)) for name in type(module.block).parameters},
        "inputs": [_port(port) for port in module.inputs],
        "outputs": [_port(port) for port in module.outputs],
        "registers": [
            {"name": r.name, "of": r.text, "format": str(r.word), "width": r.word.width, "reset": r.start}
            for r in module.registers
        ],
        "cost": module_cost(module).as_data(),
    }


def _summary(data: Mapping[str, Any]) -> str:
    blocks = len(data["instances"])
    late = data["latency"]
    return (
        f"Module {data['top']} of {blocks} block{'s' if blocks > 1 else ''}, a tick at {data['clock']}, "
        f"outputs {late} tick{'' if late == 1 else 's'} late; "
        f"before synthesis {cost_text(data['cost'])}. "
        f"The test bench plays {data['vectors']:,} clocks of the simulation."
    )


def _ports(sides: Iterable[tuple[str, Sequence[Mapping[str, Any]]]]) -> str:
    rows = [
        f"<th>{broken(port['name'])}<br>{small(port['doc'].strip().partition(chr(10))[0])}</th><td>{side}</td>"
        f"<td>{escape(port['format'])}</td><td>{escape(port['unit'])}</td><td>{broken(port['signal'])}</td>"
        for side, ports in sides
        for port in ports
    ]
    return table(("port", "", "format", "unit", "signal"), rows)


def _blocks(data: Mapping[str, Any]) -> str:
    """Table of the cost of each block, without empty columns."""
    costs = {module["name"]: module["cost"] for module in data["modules"]}
    kinds = {key: text for key, text in _COSTS.items() if data["cost"][key]}
    rows = [
        f"<th>{broken(each['block'])}</th><td>{broken(each['module'])}</td>"
        f'<td class="number">{each["clocks_per_tick"]:,}</td>{_cost_cells(costs[each["module"]], kinds)}'
        for each in data["instances"]
    ]
    rows.append(f"<th>all</th><td></td><td></td>{_cost_cells(data['cost'], kinds)}")
    numbers = [2, *(3 + i for i, key in enumerate(kinds) if not key.endswith("multipliers"))]
    return table(("block", "module", "clocks a tick", *kinds.values()), rows, numbers)


def _cost_cells(cost: Mapping[str, Any], kinds: Iterable[str]) -> str:
    return "".join(
        f"<td>{_shapes(cost[key])}</td>" if isinstance(cost[key], dict) else f'<td class="number">{cost[key]:,}</td>'
        for key in kinds
    )


def _shapes(shapes: Mapping[str, int]) -> str:
    return ", ".join(shape if number == 1 else f"{shape} ({number})" for shape, number in shapes.items())


def _module_page(module: Mapping[str, Any]) -> str:
    registers = [
        f"<th>{broken(r['name'])}</th><td>{escape(r['of'])}</td><td>{escape(r['format'])}</td>"
        f'<td class="number">{r["reset"]}</td>'
        for r in module["registers"]
    ]
    parts = [f"<p>{escape(module['kind'])}</p>", _ports([("in", module["inputs"]), ("out", module["outputs"])])]
    if registers:
        parts.append(table(("register", "of the step", "format", "at reset"), registers, numbers=(3,)))
    parts.append(facts(module["parameters"].items()))
    return "\n".join(parts)


def _found(found: Mapping[str, Any]) -> str:
    """Section of results by name: a fact each, or a table of facts."""
    return facts((name, value if isinstance(value, str) else json.dumps(value)) for name, value in found.items())
