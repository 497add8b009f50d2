"""Tabs of a live page besides the run: margins and noise of the graph with its changed parameters."""

from typing import TYPE_CHECKING

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Graph
from proofmass.runner.output.live.session import Answer, Tabs

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def margins_tab(graph: Graph) -> Answer:
    """Margins of every loop, with Bode, Nyquist and step response."""
    # start-up time: analyses and matplotlib, of which a page without this tab needs nothing
    from proofmass.runner.analysis.margins.plot import plot_margins
    from proofmass.runner.analysis.margins.stability import all_margins
    from proofmass.runner.commands.texts.margins import margins_text
    from proofmass.runner.planning.plan import plan

    loops = all_margins(plan(graph))
    pictures = (_picture(plot_margins(margins), f"loop_{number}") for number, margins in enumerate(loops.values()))
    return Answer("\n\n".join(map(margins_text, loops.values())), tuple(pictures))


def noise_tab(graph: Graph) -> Answer:
    """The noise budget of each scalar signal that is probed."""
    # start-up time: as above
    from proofmass.runner.analysis.noise.budget import noise
    from proofmass.runner.analysis.noise.plot import plot_noise
    from proofmass.runner.commands.noise_command import noise_text

    texts, pictures, refusals = list[str](), list[str](), list[ModelError]()
    for number, probe in enumerate(graph.probes):
        try:
            budget = noise(graph, probe.signal)
        except ModelError as error:
            refusals.append(error)
            continue
        texts.append(noise_text(budget))
        pictures.append(_picture(plot_noise(budget), f"noise_{number}"))
    if refusals and not texts:
        raise refusals[0]
    return Answer("\n\n".join(texts), tuple(pictures))


def _picture(figure: "Figure", name: str) -> str:
    # start-up time: matplotlib
    from proofmass.runner.output.page import picture

    return picture(figure, name)


TABS: Tabs = {"margins": margins_tab, "noise": noise_tab}
