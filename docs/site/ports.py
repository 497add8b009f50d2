"""A block as a small picture: its inputs at the left, its outputs at the right, with their units."""

from html import escape
from typing import Any

_ROW, _TOP, _LETTER = 22, 34, 6.7


def ports_picture(about: dict[str, Any]) -> str:
    """Return the SVG of a block's facts, as `proofmass.blocks.declaration.catalog.facts` gives them."""
    inputs, outputs = about["inputs"], about["outputs"]
    labels = [max((len(name) for name in ports), default=0) for ports in (inputs, outputs)]
    units = [max((len(_unit(port)) for port in ports.values()), default=0) for ports in (inputs, outputs)]
    width = max(_LETTER * (sum(labels) + 4), _LETTER * 1.25 * len(about["kind"]) + 24, 90)
    left, right = (max(_LETTER * count + 12, 28) for count in units)
    height = _TOP + _ROW * max(len(inputs), len(outputs), 1) + 4
    whole, tall = left + width + right, height + 4
    lines = [
        f'<svg class="ports" role="img" aria-label="{escape(about["kind"])} and its ports" width="{whole:.0f}" '
        f'height="{tall:.0f}" viewBox="0 0 {whole:.0f} {tall:.0f}" xmlns="http://www.w3.org/2000/svg">',
        f'<rect class="{"continuous" if about["continuous"] else "box"}" x="{left:.0f}" y="2" width="{width:.0f}" '
        f'height="{height:.0f}" rx="{14 if about["continuous"] else 2}"/>',
        f'<text class="kind" x="{left + width / 2:.0f}" y="20" text-anchor="middle">{escape(about["kind"])}</text>',
    ]
    for row, (name, port) in enumerate(inputs.items()):
        lines += _port(name, port, 0, left, left + 8, "start", _TOP + _ROW * row + 10)
    for row, (name, port) in enumerate(outputs.items()):
        start = left + width
        lines += _port(name, port, start, whole, start - 8, "end", _TOP + _ROW * row + 10)
    return "\n".join([*lines, "</svg>"])


def _port(name: str, port: dict[str, Any], start: float, end: float, label: float, anchor: str, y: float) -> list[str]:
    return [
        f'<path class="wire" d="M{start:.0f} {y:.0f}H{end:.0f}"/>',
        f'<path class="tip" d="M{end:.0f} {y:.0f}l-7 -3.5v7z"/>',
        f'<text class="port" x="{label:.0f}" y="{y + 4:.0f}" text-anchor="{anchor}">{escape(name)}</text>',
        f'<text class="unit" x="{(start + end) / 2 - 2:.0f}" y="{y - 4:.0f}" text-anchor="middle">'
        f"{escape(_unit(port))}</text>",
    ]


def _unit(port: dict[str, Any]) -> str:
    """Return the unit for the wire; nothing for plain numbers and for units that a parameter says."""
    unit = str(port["unit"])
    return "" if unit in ("", "1") or "{" in unit else unit.replace("*", "·")
