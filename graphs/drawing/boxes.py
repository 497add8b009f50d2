"""Blocks of a diagram as SVG: symbol, name, settings, ports with their details as tooltips."""

from collections.abc import Iterable, Iterator, Mapping

from proofmass.graphs.drawing.items import Spot
from proofmass.graphs.drawing.links import WiredPorts
from proofmass.graphs.drawing.looks import NAME, SYMBOL, Look, kind_text
from proofmass.graphs.drawing.picture import TAB, Box
from proofmass.graphs.drawing.style import SHADES
from proofmass.graphs.drawing.tabs import arrow
from proofmass.graphs.drawing.texts import text, unit_in_print
from proofmass.graphs.model.rates import write_rate

FLAG = "v-14h{0}l{1} 3.5l{2} 3.5h{3}"


def flag(way: int) -> str:
    """Return the mark of a probe, to the right or to the left."""
    return FLAG.format(8 * way, -3 * way, 3 * way, -8 * way)


def block_lines(
    name: str, box: Box, look: Look, spot: Spot, wired: WiredPorts, classes: Iterable[str], formats: Mapping[str, str]
) -> Iterator[str]:
    """Yield a block with its ports but for its end tag; unused outputs have a soft colour."""
    x, y, width, height = spot.x, spot.y, look.shape.width, look.shape.height
    middle = x + width / 2
    if look.symbol == "tab":
        yield f'<g class="tab"><title>{text(box.doc)}</title>{_tab(name, box, look, spot)}'
        return
    about = ["block", *["continuous"] * box.continuous, *["open"] * (look.symbol == "open"), *classes]
    part = f' data-part="{text(box.path)}"' if box.subgraph else ""
    yield f'<g class="{" ".join(about)}" data-block="{text(box.path)}"{part}>'
    yield f"<title>{text(_tooltip(name, box, wired.into[name]))}</title>"
    if look.symbol in ("circle", "triangle"):
        yield f'<rect class="area" x="{x}" y="{y}" width="{width}" height="{height}"/>'
        yield from _symbol(look, spot)
        yield f'<text class="name" x="{middle:g}" y="{y + 14}" text-anchor="middle">{text(name)}</text>'
    else:
        yield from _frame(name, box, look, spot)
    first = y + height - 6 - 20 * (len(look.settings) - 1) if look.signs else y + 49
    for row, setting in enumerate(look.settings):
        line = f'x="{middle:g}" y="{first + 18 * row}" text-anchor="middle"'
        yield f'<text class="{"rate" if setting == look.rate else "setting"}" {line}>{text(setting)}</text>'
    yield from _ports(box, look, spot, wired.probed[name], {*look.shape.inputs, *wired.used[name]}, formats)
    for parameter, across in look.shape.driven.items():
        source, _, output = wired.into[name][parameter].rpartition(".")
        shade = wired.net_of[source, output] % SHADES
        line = f'x="{x + across}" y="{y + height - 7}" text-anchor="middle"'
        yield f'<text class="port net{shade}" {line}>{text(parameter)}</text>'


def _frame(name: str, box: Box, look: Look, spot: Spot) -> Iterator[str]:
    x, y, width, height = spot.x, spot.y, look.shape.width, look.shape.height
    middle = x + width / 2
    corner = 14 if box.continuous else 2
    yield f'<rect class="box" x="{x}" y="{y}" width="{width}" height="{height}" rx="{corner}"/>'
    if box.subgraph and look.symbol == "box":
        yield f'<rect class="box" x="{x + 3}" y="{y + 3}" width="{width - 6}" height="{height - 6}"/>'
    yield f'<text class="name" x="{middle:g}" y="{y + 18}" text-anchor="middle">{text(name)}</text>'
    extra = f'<tspan class="rate" dx="6">{text(look.rate)}</tspan>' if look.rate else ""
    kind = f"{text(kind_text(box))}{extra}"
    yield f'<text class="soft" x="{middle:g}" y="{y + 33}" text-anchor="middle">{kind}</text>'
    if box.subgraph:
        upright, act = ("", "Fold") if look.symbol == "open" else ("M0 -4V4", "Unfold")
        yield (
            f'<g class="fold" data-fold="{text(box.path)}" role="button" tabindex="0" '
            f'transform="translate({x + 14} {y + 14})"><title>{act} {text(name)}</title>'
            f'<rect class="mark box" x="-7" y="-7" width="14" height="14"/><path d="M-4 0H4{upright}"/></g>'
        )


def _symbol(look: Look, spot: Spot) -> Iterator[str]:
    left, top = spot.x + (look.shape.width - SYMBOL) / 2, spot.y + NAME
    if look.symbol == "circle":
        tall = look.shape.height - NAME - 20 * len(look.settings)
        yield f'<rect class="box" x="{left:g}" y="{top}" width="{SYMBOL}" height="{tall}" rx="{SYMBOL // 2}"/>'
        across = left + (SYMBOL - 11 if spot.mirrored else 11)
        for port, sign in look.signs.items():
            line = f'x="{across:g}" y="{spot.y + look.shape.inputs[port] + 5}" text-anchor="middle"'
            yield f'<text class="sign" {line}>{sign}</text>'
        return
    way = -1 if spot.mirrored else 1
    base = left + SYMBOL * (way < 0)
    yield f'<path class="box" d="M{base:g} {top}v{SYMBOL}l{way * SYMBOL} -{SYMBOL // 2}Z"/>'
    (sign,) = look.signs.values()
    if sign:
        yield f'<text class="sign" x="{base + 15 * way:g}" y="{top + 25}" text-anchor="middle">{sign}</text>'


def _tab(name: str, box: Box, look: Look, spot: Spot) -> str:
    """Return a port of an opened subgraph: an arrow that its name stands in."""
    x, y, width = spot.x, spot.y, look.shape.width
    label = name.strip(TAB)
    return (
        f'<path class="box" d="{arrow(x, y, width, 10, spot.mirrored)}"/>'
        f'<text x="{x + width / 2:g}" y="{y + 14}" text-anchor="middle">{text(label)}</text>'
    )


def _ports(
    box: Box, look: Look, spot: Spot, probed: set[str], used: set[str], formats: Mapping[str, str]
) -> Iterator[str]:
    x, y, right = spot.x, spot.y, spot.x + look.shape.width
    for ports, on_right in ((look.shape.inputs, spot.mirrored), (look.shape.outputs, not spot.mirrored)):
        at, anchor = (right - 8, ' text-anchor="end"') if on_right else (x + 8, "")
        for port, below in ports.items():
            if port in look.labels:
                style = "port" if port in used else "port soft"
                yield f'<text class="{style}" x="{at}" y="{y + below + 4}"{anchor}>{text(port)}</text>'
    for port, below in look.shape.outputs.items():
        edge, way, anchor = (x, -1, ' text-anchor="end"') if spot.mirrored else (right, 1, "")
        height, start = y + below, edge + 4 * way
        inset = look.insets.get(port, 0.0)
        if port in probed:
            yield f'<path class="probe" d="M{edge - inset * way:g} {height}h{(8 + inset) * way:g}m0 0{flag(way)}"/>'
            start += 16 * way
        unit = unit_in_print(box.outputs[port])
        if unit and port in used:
            yield f'<text class="soft small plain" x="{start}" y="{height - 4}"{anchor}>{text(unit)}</text>'
        if port in used:
            short = box.types[port].removeprefix("fixed point ")
            if port in look.tabs:
                start = edge + way * (sum(look.tabs[port]) + 4)
            style = f"small only formats {formats[port]}"
            yield f'<text class="{style}" x="{start}" y="{height - 4}"{anchor}>{text(short)}</text>'


def _tooltip(name: str, box: Box, drivers: Mapping[str, str]) -> str:
    lines = [f"{name}: {kind_text(box)}", box.doc]
    if box.continuous:
        lines.append("continuous")
    elif box.rate:
        lines.append(f"at {write_rate(box.rate)}")
    for parameter, declared in box.parameters.items():
        value = box.values[parameter]
        unit = unit_in_print(declared)
        if parameter in drivers:
            lines.append(f"{parameter}: driven by {drivers[parameter]}")
        elif declared.kind in (float, int):
            lines.append(f"{parameter} = {box.in_full(parameter)}")
        else:
            said = f"{len(value)} values" if isinstance(value, tuple) and len(value) > 8 else f"{value}"
            lines.append(f"{parameter} = {said} {unit}".rstrip())
    return "\n".join(line for line in lines if line)
