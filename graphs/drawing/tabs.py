"""Tabs of a diagram: arrows that a name stands in, for ports of opened subgraphs and for wires that are named."""

from proofmass.graphs.drawing.texts import text

_HALF = 8  # height of a tab of a wire, above and below its line


def arrow(x: float, y: float, width: int, half: int, mirrored: bool) -> str:
    """Return the outline of an arrow as a path; `x` and `y` are its upper left corner, `half` is half of its height."""
    if mirrored:
        return f"M{x + width:g} {y:g}h{half - width}l-{half} {half}l{half} {half}H{x + width:g}Z"
    return f"M{x:g} {y:g}h{width - half}l{half} {half}l-{half} {half}H{x:g}Z"


def tab_of_wire(label: str, end: tuple[float, float], width: int, mirrored: bool, shade: str) -> str:
    """Return the tab of a wire in the way of its signal; `end` is the middle of its point."""
    x, y = end[0] - width * (not mirrored), end[1]
    middle = x + width / 2 + (3 if mirrored else -3)
    return _tab(arrow(x, y - _HALF, width, _HALF, mirrored), label, (middle, y + 4), shade)


def tab_below(label: str, end: tuple[float, float], width: int, shade: str) -> str:
    """Return the tab of a wire that drives a parameter: it points up at `end`."""
    x, y = end[0] - width / 2, end[1]
    outline = f"M{x:g} {y + 19:g}h{width}v-14H{end[0] + 5:g}l-5 -5l-5 5H{x:g}Z"
    return _tab(outline, label, (end[0], y + 15.5), shade)


def _tab(outline: str, label: str, at: tuple[float, float], shade: str) -> str:
    place = f'x="{at[0]:g}" y="{at[1]:g}" text-anchor="middle"'
    return f'<path class="label" d="{outline}"/><text class="{f"small {shade}".strip()}" {place}>{text(label)}</text>'
