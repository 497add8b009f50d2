"""Which sources of noise are recorded beside a quantiser of one bit."""

from proofmass import Graph
from proofmass.blocks import Comparator, Constant, Difference, DiscreteIntegrator, Sum, WhiteNoise
from proofmass.runner.analysis.decisions.compiled_decisions import _sources
from proofmass.runner.planning.plan import plan


def test_sources_that_draw_a_number_at_each_decision() -> None:
    """Not one at another rate, none that the quantiser does not hear, and nothing that draws no number."""
    graph = Graph(
        name="",
        rate=1000,
        blocks={
            "hiss": WhiteNoise(density=0.1),
            "slow": WhiteNoise(density=0.1),
            "elsewhere": WhiteNoise(density=0.1),
            "level": Constant(value=0.1),
            "noisy": Sum(),
            "both": Sum(),
            "error": Difference(),
            "total": DiscreteIntegrator(output_unit="1"),
            "bit": Comparator(),
        },
        rates={"slow": 100},
        wires=[
            *("hiss.output -> noisy.first", "level.output -> noisy.second"),
            *("noisy.output -> both.first", "slow.output -> both.second"),
            *("both.output -> error.first", "bit.sign -> error.second"),
            *("error.output -> total.input", "total.output -> bit.input"),
        ],
    )
    planned = plan(graph)
    assert list(_sources(planned, set(planned.blocks) - {"elsewhere"}, {"bit": "sign"})) == ["hiss.output"]
