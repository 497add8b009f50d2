"""The page of the Python API: every public name, its signature and docstring by Sphinx's autodoc."""

import inspect
from typing import Any

import proofmass
from docs.site.markdown import code, plain, table
from docs.site.reference_fields import fields

GROUPS = {  # the heading of each name; a name that is nowhere ends the build
    "Graphs": ("Graph", "Wire", "Probe", "read_graph", "write_graph", "check"),
    "Runs": ("simulate", "Result", "Trace"),
    "Blocks of your own": ("Block", "Input", "Buffer", "block", "param"),
    "Margins and linearisation": ("margins", "Margins", "linearise"),
    "Noise, spectra, Allan deviations": (
        "noise", "NoiseBudget", "deviation_over_runs", "ValueDeviation", "spectrum", "Spectrum", "tones", "Tones",
        "allan", "Allan", "read_series", "Series",
    ),
    "Tuning, fits, worst cases": (
        "tune", "read_tuning", "Tuned", "Tuning", "fit", "Fitted", "worst", "WorstCases", "margins_together",
        "margins_over", "margins_over_age",
    ),
    "Studies": ("Study", "StudyResult", "read_study", "run_study", "replay"),
    "Problems": ("Problem", "ModelError", "RunError"),
}  # fmt: skip


def groups() -> dict[str, list[str]]:
    """Return the public names by heading; those that are grouped nowhere come under "More"."""
    public = set(proofmass.__all__)
    grouped = {title: [name for name in names if name in public] for title, names in GROUPS.items()}
    rest = sorted(public - {name for names in grouped.values() for name in names})
    return grouped | ({"More": rest} if rest else {})


def python_page() -> str:
    """Return the page of the Python API."""
    lines = ["# Python", "", "Everything is imported from `proofmass`; blocks come from `proofmass.blocks`.", ""]
    for title, names in groups().items():
        lines += [f"## {title}", ""]
        for name in names:
            lines += [f"### {name}", "", "```{eval-rst}"]
            lines += [f".. {_directive(getattr(proofmass, name))}:: proofmass.{name}", *_options(name), "```", ""]
            lines += _fields_of(name)
    return "\n".join(lines) + "\n"


def _directive(thing: Any) -> str:
    if inspect.isclass(thing):
        return "autoexception" if issubclass(thing, Exception) else "autoclass"
    return "autofunction"


def _options(name: str) -> list[str]:
    return ["   :members:"] if inspect.isclass(getattr(proofmass, name)) else []


def _fields_of(name: str) -> list[str]:
    """Return the table of the fields of a class; nothing of a function."""
    thing = getattr(proofmass, name)
    rows = (
        [(code(field.name), code(field.type), plain(field.meaning)) for field in fields(thing)]
        if inspect.isclass(thing)
        else []
    )
    return [*table((f"field of {name}", "type", "meaning"), rows), ""] if rows else []
