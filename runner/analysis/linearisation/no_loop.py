"""Problems of an output at which no loop can be opened."""

from proofmass.blocks.declaration.problem import Problem, problem_of_output
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.find_loops import find_loops
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.planned import Plan


def no_gain(node: Endpoint) -> Problem:
    """Nothing that goes in at the output comes back to it."""
    return problem_of_output(
        node,
        message=f"what goes in at {'.'.join(node)} does not come back",
        expected="a loop in which every block passes small changes on",
        hint="a limit may be reached there, or a signal only compared; try another time with --at",
    )


def not_periodic(node: Endpoint) -> Problem:
    """Loops in continuous time have no margins about an orbit."""
    signal = ".".join(node)
    return problem_of_output(
        node,
        message=f"a loop among continuous blocks is opened at {signal}: about a periodic orbit it has no margins",
        expected="an output that is sampled or held",
        hint="open the loop at a discrete block, or name a time with --at",
    )


def not_within(planned: Plan, group: Group, node: Endpoint) -> Problem:
    """Between continuous blocks signals are not held: no sampled loop can be cut there."""
    signal = ".".join(node)
    wires = planned.schedule.drivers.items()
    readers = [f"{name}.{entry}" for (name, entry), source in wires if source == node and name in group.members]
    cuts = [cut for part in find_loops(planned) if signal in part.ports for cut in part.open_at]
    return problem_of_output(
        node,
        message=f"no loop among continuous blocks goes through {signal}, and between them nothing is sampled",
        got=", ".join(sorted(readers)),
        expected="an output whose values are sampled or held",
        hint=f"open the loop at {' or '.join(cuts[:3])}" if cuts else "open the loop at a discrete block",
    )
