"""The scripts and styles of a live page: plain modules, one after the other, and leave for a browser to run them."""

import base64
import hashlib
import re
from functools import cache
from pathlib import Path

_FOLDER = Path(__file__).parent
# each imports those before it
_MODULES = (
    *("modules", "formulas", "engine", "figures", "quantities", "values", "gestures", "beside", "worker", "charts"),
    *("controls", "wires", "diagrams", "picked", "strip", "histograms", "measures", "leading", "long", "said", "seeds"),
    *("fields", "places", "plotted", "view", "served", "page"),
)
_IMPORT = re.compile(r'^import \{[^}]*\} from "\./\w+\.mjs";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|class|const))", re.MULTILINE)


@cache
def script() -> str:
    """The modules as one script; what they import of each other is in it already."""
    texts = (_read(f"{name}.mjs") for name in _MODULES)
    joined = "\n".join(_EXPORT.sub("", _IMPORT.sub("", text)) for text in texts)
    return f'"use strict";\n{joined}'


@cache
def plots() -> str:
    """uPlot, the library that draws, with its licence."""
    return f"/*\n{_read('vendor/uPlot.LICENSE')}*/\n{_read('vendor/uPlot.iife.min.js')}"


@cache
def styles() -> str:
    """Styles of the live part."""
    return _read("vendor/uPlot.min.css") + _read("live.css")


def elements() -> str:
    """The library and the script as elements of a page."""
    return f'<script>{plots()}</script>\n<script id="live-script">{script()}</script>\n'


def allowed() -> str:
    """The words of a content security policy that let these run, and their workers."""
    return f"; script-src 'wasm-unsafe-eval' {permission(plots())} {permission(script())}; worker-src blob:"


def permission(text: str) -> str:
    """The word of a content security policy that allows an inline script."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _read(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
