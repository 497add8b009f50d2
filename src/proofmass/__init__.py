"""proofmass: a block-diagram dataflow simulator for inertial sensors.

    from proofmass import Graph, simulate
    from proofmass.blocks import ShiftRegister

The names below are imported when they are first used, so that `import proofmass` costs nothing.
"""

from importlib import import_module
from sys import modules
from typing import Any

# The one table of public names; `python -m tests.documents.stubs` writes __init__.pyi from it.
_HOMES = {
    "Allan": "runner.analysis.allan.deviations",
    "Block": "blocks.declaration.declare",
    "Buffer": "blocks.declaration.declare",
    "Fitted": "runner.design.identification.fitted",
    "Graph": "graphs.model.build",
    "Input": "blocks.declaration.declare",
    "Margins": "runner.analysis.margins.margins",
    "Modulator": "runner.design.modulators.modulator",
    "ModelError": "blocks.declaration.problem",
    "NoiseBudget": "runner.analysis.noise.noise_budget",
    "Probe": "graphs.model.graph",
    "Problem": "blocks.declaration.problem",
    "Response": "runner.analysis.response.response",
    "Result": "runner.run.result",
    "RunError": "runner.run.faults",
    "Series": "runner.analysis.spectrum.series",
    "Spectrum": "runner.analysis.spectrum.welch",
    "Study": "graphs.studies.build",
    "StudyResult": "runner.studies.outcome.result",
    "Sweep": "runner.run.sweep",
    "Tones": "runner.analysis.spectrum.tones",
    "Trace": "runner.run.result",
    "Tuned": "runner.design.tune.tune",
    "Tuning": "graphs.tuning.tuning",
    "ValueDeviation": "runner.analysis.noise.over_runs",
    "Wire": "graphs.model.graph",
    "Proofs": "runner.design.proof.prove",
    "WorstCases": "runner.design.worst.worst",
    "allan": "runner.analysis.allan.deviations",
    "block": "blocks.declaration.declare",
    "check": "runner.studies.whole.ready",
    "design_modulator": "runner.design.modulators.modulator",
    "deviation_over_runs": "runner.analysis.noise.over_runs",
    "fit": "runner.design.identification.fitted",
    "from_control": "graphs.model.linear_systems",
    "from_scipy": "graphs.model.linear_systems",
    "linearise": "runner.analysis.linearisation.linearise",
    "margins_over": "runner.analysis.several.over",
    "margins_over_age": "runner.analysis.several.over",
    "margins_together": "runner.analysis.several.together",
    "margins": "runner.analysis.margins.stability",
    "noise": "runner.analysis.noise.budget",
    "param": "blocks.declaration.declare",
    "prove": "runner.design.proof.prove",
    "read_graph": "graphs.files.toml_reader",
    "read_series": "runner.analysis.spectrum.series",
    "read_study": "graphs.studies.study_reader",
    "read_tuning": "graphs.tuning.reader",
    "read_variants": "graphs.studies.study_reader",
    "replay": "runner.studies.whole.study",
    "response": "runner.analysis.response.response",
    "run_study": "runner.studies.whole.study",
    "second_opinion": "runner.analysis.margins.second_opinion",
    "simulate": "runner.run.simulate",
    "spectrum": "runner.analysis.spectrum.welch",
    "sweep": "runner.run.sweep",
    "tones": "runner.analysis.spectrum.tones",
    "tune": "runner.design.tune.tune",
    "worst": "runner.design.worst.worst",
    "write_graph": "graphs.files.toml_writer",
}

# The picture that `plot()` makes of each kind of result.
_PICTURES = {
    "Allan": "runner.analysis.allan.plot.plot_allan",
    "Fitted": "runner.design.identification.plot.plot_fitted",
    "Margins": "runner.analysis.margins.plot.plot_margins",
    "Modulator": "runner.design.modulators.plot.plot_modulator",
    "NoiseBudget": "runner.analysis.noise.plot.plot_noise",
    "Response": "runner.analysis.response.plot.plot_response",
    "Result": "runner.output.plot.plot_traces",
    "Spectrum": "runner.analysis.spectrum.plot.plot_spectrum",
    "StudyResult": "runner.studies.shown.plot.plot_study",
    "Trace": "runner.output.plot.plot_trace",
    "Tuned": "runner.design.tune.plot.plot_tuned",
    "WorstCases": "runner.design.worst.plot.plot_worst",
}

# The text for people of each kind of result, as its command prints it.
_TEXTS = {
    "Allan": "runner.analysis.allan.text.allan_text",
    "Fitted": "runner.design.identification.text.fitted_text",
    "Modulator": "runner.design.modulators.text.modulator_text",
    "Response": "runner.analysis.response.text.response_text",
    "Spectrum": "runner.analysis.spectrum.text.spectrum_text",
    "Tuned": "runner.design.tune.text.tuned_text",
    "ValueDeviation": "runner.analysis.noise.text.value_text",
    "Proofs": "runner.design.proof.text.proofs_text",
    "WorstCases": "runner.design.worst.text.worst_text",
}

__all__ = sorted(_HOMES)


def picture_of(result: Any) -> Any:
    """Return the picture of a result, a figure of matplotlib."""
    return _made(_PICTURES, result)


def text_of(result: Any) -> Any:
    """Return the text of a result for people."""
    return _made(_TEXTS, result)


def _made(by_kind: dict[str, str], result: Any) -> Any:
    module, _, function = by_kind[type(result).__name__].rpartition(".")
    return getattr(import_module(f"proofmass.{module}"), function)(result)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("proofmass.runner.host.versions").PROOFMASS
    if name in _HOMES:
        try:
            public = getattr(import_module(f"proofmass.{_HOMES[name]}"), name)
        except ImportError as error:
            raise import_module("proofmass.blocks.declaration.libraries").told(error) or error from None
        if "proofmass.graphs.model.build" in modules:
            modules["proofmass.graphs.model.build"].Graph.drawn = _drawn
        return public
    raise import_module("proofmass.blocks.declaration.absent_names").absent("proofmass", name, _instead(name))


def _instead(name: str) -> str:
    """What was meant by a name that the package does not have."""
    if name.startswith("_"):
        return ""  # asked for by tools, again and again
    others = import_module("proofmass.blocks.declaration.other_functions")
    if others.drawn_by(name):
        return f"; {others.drawn_by(name)}"
    if name.islower() and others.function_of(name):
        return f"; did you mean {others.function_of(name)}?"
    blocks = import_module("proofmass.blocks.declaration.families").homes()
    if name.lower() in blocks:
        return f"; a block comes from proofmass.blocks: from proofmass.blocks import {name}"
    if hasattr(import_module("proofmass.blocks.declaration.kind").BlockType, name.lower()):
        written = "`proofmass new blocks.py` writes an example"
        return f"; it is a decorator of a kind of block, as @KIND.{name.lower()}: {written}"
    near = import_module("proofmass.blocks.declaration.problem").nearest(name, _HOMES)
    return f"; did you mean {near}?" if near else "; dir(proofmass) lists all names"


def _drawn(graph: Any) -> str:
    """The diagram that a notebook shows of a graph."""
    return str(import_module("proofmass.graphs.drawing.diagram").svg(graph))


def __dir__() -> list[str]:
    return sorted(["__version__", "blocks", *__all__])
