"""Styles of diagrams, light and dark, and those of overlays.

Okabe and Ito's colours differ for every kind of colour vision; shape and dashes say the same again.
"""

SHADES = 6  # of overlays, and of wires that drive parameters; the next begins again
_LIGHT = ("#0072b2", "#9a5b00", "#00775a", "#a0487a", "#444", "#b03a00")
_DARK = ("#56b4e9", "#e69f00", "#2fc39a", "#e29ac4", "#bbb", "#ff8a4a")
_DASHES = ("5 3", "9 3", "2 2.5", "9 3 2 3", "6 2 2 2 2 2", "14 4")

_BASE = """
.proofmass{--paper:#fff;--ink:#1a2530;--soft:#5b6b7a;--face:#f5f7f9;--flow:#e4f1fb;--wire:#3d4f60;--drive:#0072b2;--look:#c04a00;LIGHT}
@media screen and (prefers-color-scheme:dark){.proofmass{--paper:#12181e;--ink:#e8eef3;--soft:#a3b1be;--face:#1d262f;\
--flow:#12324a;--wire:#a9bac9;--drive:#56b4e9;--look:#f0a04b;DARK}}
svg.proofmass:root{background:var(--paper)}
.proofmass text{font:11px "Helvetica Neue",Arial,"DejaVu Sans",sans-serif;fill:#1a2530;fill:var(--ink)}
.proofmass .name{font-weight:bold;font-size:13px}
.proofmass .title{font-weight:bold;font-size:15px}
.proofmass .sign{font-weight:bold;font-size:14px}
.proofmass .soft{fill:#5b6b7a;fill:var(--soft)}
.proofmass .small{font-size:10px}
.proofmass .rate{fill:#0072b2;fill:var(--drive);font-weight:bold}
.proofmass .paper{fill:#fff;fill:var(--paper)}
.proofmass .box{fill:#f5f7f9;fill:var(--face);stroke:#1a2530;stroke:var(--ink);stroke-width:1.4}
.proofmass .area{fill:none;pointer-events:all}
.proofmass .continuous .box{fill:#e4f1fb;fill:var(--flow)}
.proofmass .open>.box{fill:#fff;fill:var(--paper);stroke-dasharray:none}
.proofmass .line{fill:none;stroke:#3d4f60;stroke:var(--wire);stroke-width:1.5}
.proofmass .bundle .line{stroke-width:3.5}
.proofmass .count{stroke:#3d4f60;stroke:var(--wire);stroke-width:1.5}
.proofmass .label{fill:#fff;fill:var(--paper);stroke:#3d4f60;stroke:var(--wire);stroke-width:1}
.proofmass .reach{fill:none;stroke:#0072b2;stroke:var(--drive);stroke-width:9;stroke-opacity:0}
.proofmass .tip,.proofmass .dot{fill:#3d4f60;fill:var(--wire)}
.proofmass .probe{fill:#c04a00;fill:var(--look);stroke:#c04a00;stroke:var(--look);stroke-width:1.4}
.proofmass :is(.wire,.bundle,.named):hover .reach,.proofmass .marked .reach{stroke-opacity:.35}
.proofmass .named:hover .label,.proofmass .marked .label{fill:#e4f1fb;fill:var(--flow)}
.proofmass .fold,.proofmass .only{display:none}
.proofmass .fold path{stroke:#1a2530;stroke:var(--ink);stroke-width:1.6}
"""


def _style() -> str:
    shades = [";".join(f"--c{i}:{colour}" for i, colour in enumerate(colours)) for colours in (_LIGHT, _DARK)]
    lines = [_BASE.replace("LIGHT", shades[0]).replace("DARK", shades[1])]
    for i in range(SHADES):
        shade = f"{_LIGHT[i]};%s:var(--c{i})"
        net = f".proofmass .net{i}"
        lines.append(f"{net} .line{{stroke:{shade % 'stroke'};stroke-dasharray:{_DASHES[i]}}}")
        lines.append(f"{net} .tip,{net}.dot,.proofmass text.net{i}{{fill:{shade % 'fill'};font-weight:bold}}")
        for kind in ("rate", "loop"):
            box = f".proofmass.{kind}s .{kind}{i}>.box"
            lines.append(f"{box}{{fill:{shade % 'fill'};fill-opacity:.28;stroke:{shade % 'stroke'}}}")
        for kind in ("loop", "format"):
            wire = f".proofmass.{kind}s .{kind}{i}"
            lines.append(
                f"{wire}>.line{{stroke:{shade % 'stroke'};stroke-width:2.4}}{wire}>.tip{{fill:{shade % 'fill'}}}"
            )
            lines.append(f".proofmass.{kind}s text.{kind}{i}{{fill:{shade % 'fill'}}}")
    for kind in ("rates", "loops", "formats"):
        lines.append(f".proofmass.{kind} .plain{{display:none}}.proofmass.{kind} .only.{kind}{{display:inline}}")
    return "\n".join(lines) + "\n"


STYLE = _style()
