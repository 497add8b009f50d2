"""Tabs of a live page besides the run: margins, noise and spectra of the graph with its changed parameters."""

from typing import TYPE_CHECKING, NamedTuple

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Graph

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class TabAnswer(NamedTuple):
    """The process's answer for a tab: text, and pictures as SVG."""

    text: str
    pictures: tuple[str, ...] = ()


def margins_tab(graph: Graph) -> TabAnswer:
    """Margins of every loop, with Bode, Nyquist and step response."""
    # start-up time: a page without this tab needs neither analyses nor matplotlib
    from proofmass.runner.analysis.margins.plot import plot_margins
    from proofmass.runner.analysis.margins.second_opinion import second_opinion
    from proofmass.runner.analysis.margins.stability import all_margins
    from proofmass.runner.analysis.margins.text import margins_text
    from proofmass.runner.planning.plan import plan

    loops = all_margins(plan(graph))
    texts = [*map(margins_text, loops.values()), "\n".join(str(second_opinion(one)) for one in loops.values())]
    return _answer(texts, {f"loop {name}": plot_margins(margins) for name, margins in loops.items()})


def noise_tab(graph: Graph) -> TabAnswer:
    """The noise budget of each scalar signal that is probed."""
    # start-up time: as above
    from proofmass.runner.analysis.noise.budget import noise
    from proofmass.runner.analysis.noise.plot import plot_noise
    from proofmass.runner.analysis.noise.text import noise_text

    texts, figures, refusals = list[str](), dict[str, "Figure"](), list[ModelError]()
    for probe in graph.probes:
        try:
            budget = noise(graph, probe.signal)
        except ModelError as error:
            refusals.append(error)
            continue
        texts.append(noise_text(budget))
        figures[f"noise of {probe.signal}"] = plot_noise(budget)
    if refusals and not texts:
        raise refusals[0]
    return _answer(texts, figures)


def spectra_tab(graph: Graph) -> TabAnswer:
    """Amplitude density of each scalar probe over the run that the graph asks for, with the tone that stands out."""
    # start-up time: as above
    from proofmass.runner.analysis.spectrum.plot import plot_spectrum
    from proofmass.runner.analysis.spectrum.text import TONE_WINDOW, spectrum_text, tone_text
    from proofmass.runner.analysis.spectrum.tones import tones
    from proofmass.runner.analysis.spectrum.welch import spectrum
    from proofmass.runner.run.simulate import simulate

    result = simulate(graph)
    texts, figures = list[str](), dict[str, "Figure"]()
    for name, trace in result.traces.items():
        if trace.values.ndim > 1:
            texts.append(f"{name}: a vector has no spectrum here")
            continue
        try:
            density = spectrum(trace)
            whole = spectrum(trace, window=TONE_WINDOW, segment=0)
        except ModelError as error:
            texts.append(f"{name}: {error.problems[0].message}")
            continue
        try:
            tone = tones(whole)
        except ModelError:
            tone = None
        texts += [spectrum_text(density, None, None), tone_text(tone, whole)]
        figures[f"spectrum of {name}"] = plot_spectrum(density, tone)
    return _answer(texts, figures)


def _answer(texts: list[str], figures: dict[str, "Figure"]) -> TabAnswer:
    # start-up time: matplotlib
    from proofmass.runner.output.page import picture

    return TabAnswer("\n\n".join(texts), tuple(picture(figure, name) for name, figure in figures.items()))


TABS = {"margins": margins_tab, "noise": noise_tab, "spectra": spectra_tab}
