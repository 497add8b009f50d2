"""The named values of a graph as a table: what each is, and the formula that gives it."""

from proofmass.graphs.model.flatten import parts
from proofmass.graphs.model.graph import Graph
from proofmass.runner.output.text_table import text_table

_ROWS = 40


def values_text(graph: Graph) -> list[str]:
    """Return a line for each value of a graph and its subgraphs, with its formula; nothing without values."""
    rows = [
        (path + name, value.text(), value.formula.text if value.formula else "")
        for path, part in parts(graph)
        for name, value in part.values.items()
    ]
    if not rows:
        return []
    more = [f"and {len(rows) - _ROWS} more"] if len(rows) > _ROWS else []
    return ["", *text_table([("value", "is", ""), *rows[:_ROWS]], left=(0, 2)), *more]
