"""Formulas of measures as a program: the numbers are those of a run in Python, to the last bit."""

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.measure_formulas import measure_formulas
from proofmass.runner.run.simulate import simulate
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.verify_program import verify
from tests.runner.plan.test_derived_measures import GRAPH, TEXT


def test_they_give_the_measures_of_a_run() -> None:
    graph = read_graph_text(TEXT.replace("[blocks]", 'fixed = "= 2 + 3"\nturned = "= -high"\n[blocks]'))
    assert GRAPH.derived.keys() < graph.derived.keys()
    planned = plan(graph)
    measures = {name: measure.value for name, measure in simulate(graph, engine="python").measures.items()}
    program = measure_formulas(planned)
    verify(program)
    values = [measures[measure.name] for measure in planned.measures] + [0.0] * len(planned.derived)
    evaluate(program.entry, values)
    assert values[len(planned.measures) :] == [measures[derived.name] for derived in planned.derived]
