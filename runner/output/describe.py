"""One block as text: what `proofmass blocks KIND` prints, derived from its declaration."""

from collections.abc import Sequence
from textwrap import indent
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.catalog import facts
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.output.text_table import text_table


def block_text(kind: type[Block]) -> str:
    """Equation, parameters with units and bounds, ports with types and feedthrough, and lines for a graph file."""
    about = facts(kind)
    lines = [f"{about['kind']}: {about['doc']}", "", indent(about["equation"], "    ")]
    lines += ["", f"Elsewhere called: {', '.join(about['elsewhere'])}."] if about["elsewhere"] else []
    lines += ["", "Continuous: the runner integrates it between ticks."] if about["continuous"] else []
    parameters = [
        (name, _default(p), p["unit"], kind.parameters[name].bounds() or ", ".join(p.get("choices", [])), p["doc"])
        for name, p in about["parameters"].items()
    ]
    lines += _table("Parameters", ("name", "default", "unit", "bounds", ""), parameters)
    inputs = [
        (name, p["type"], p["unit"], "may stay unconnected" if "default" in p else "", p["doc"])
        for name, p in about["inputs"].items()
    ]
    lines += _table("Inputs", ("name", "type", "unit", "", ""), inputs)
    outputs = [
        (name, _type(p), p["unit"], ", ".join(p["feedthrough"]) or "nothing", p["doc"])
        for name, p in about["outputs"].items()
    ]
    lines += _table("Outputs", ("name", "type", "unit", "depends at once on", ""), outputs)
    return "\n".join([*lines, "", "In a graph file:", *_example(kind)])


def _example(kind: type[Block]) -> list[str]:
    lines = ["    [blocks.name]", f'    kind = "{kind.__name__}"']
    for name, p in kind.parameters.items():
        if p.kind is float and p.unit != "1" and "{" not in p.unit:
            lines.append(f'    {name} = "{p.default:g} {p.unit}"')
        elif p.kind is bool:
            lines.append(f"    {name} = {'true' if p.default else 'false'}")
        elif p.kind in (str, Fixed):
            lines.append(f'    {name} = "{p.default}"')
        else:
            lines.append(f"    {name} = {list(p.default) if isinstance(p.default, tuple) else repr(p.default)}")
    return lines


def _default(parameter: dict[str, Any]) -> str:
    default = parameter["default"]
    return f"{default:g}" if isinstance(default, float) else str(default)


def _type(port: dict[str, Any]) -> str:
    shape = f"[{', '.join(map(str, port['shape']))}]" if "shape" in port else ""
    return str(port["type"]) + shape + (f", every {port['every']} ticks" if "every" in port else "")


def _table(title: str, head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[str]:
    if not rows:
        return []
    return ["", title, *(f"    {line}" for line in text_table([head, *rows], left=range(len(head)), indent=4))]
