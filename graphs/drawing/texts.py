"""Texts in drawings: their widths, and what XML can hold of them."""

import re
from html import escape

from proofmass.blocks.declaration.declare import Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.blocks.declaration.units import short_unit

_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML


def width_of(text: str, size: int, bold: bool = False) -> int:
    """Return the width of a text in pixels, estimated generously."""
    narrow = sum(c in "iljtfrI.,:;|!'()[]/ ·" for c in text)
    wide = sum(c in "mwMW@%" for c in text)
    units = 0.6 * (len(text) - narrow - wide) + 0.36 * narrow + 0.9 * wide
    return round(units * size * (1.08 if bold else 1.0) + 0.5)


def plain(text: str) -> str:
    """Return a text with what XML cannot hold replaced."""
    return _ILLEGAL.sub("\N{REPLACEMENT CHARACTER}", text)


def text(text: str) -> str:
    """Return a text for XML."""
    return escape(plain(text))


def unit_in_print(what: Port | Parameter) -> str:
    """Return the unit as written by hand; empty for a plain number."""
    unit = pretty(short_unit(what.unit))
    return "" if unit == "1" else unit
