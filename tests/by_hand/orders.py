"""The same graph in another order: as it is declared, and as it is run."""

import ast
import dataclasses
import functools
import inspect
import random
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar

from proofmass.graphs.checks.schedule import ConstantsOf, OutputStep
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import split
from proofmass.runner.planning.plan import Plan

Thing = TypeVar("Thing")


def mixed(things: Iterable[Thing], dice: random.Random) -> list[Thing]:
    """The things in another order."""
    order = list(things)
    dice.shuffle(order)
    return order


def shuffled(graph: Graph, dice: random.Random) -> Graph:
    """The same graph with blocks, rates, wires and probes declared in another order, inside its subgraphs too."""
    parts = {name: shuffled(part, dice) for name, part in graph.subgraphs.items()}
    return dataclasses.replace(
        graph,
        blocks=dict(mixed([*graph.blocks.items(), *parts.items()], dice)),
        subgraphs={},
        rates=dict(mixed(graph.rates.items(), dice)),
        wires=mixed(graph.wires, dice),
        probes=mixed(graph.probes, dice),
        exports=dict(mixed(graph.exports.items(), dice)),
    )


def in_another_order(plan: Plan, dice: random.Random) -> Plan:
    """The plan with outputs in any order that is legal, updates in any order, and continuous groups in any order."""
    order = legal_order(needs(plan.graph), dice)
    graph = dataclasses.replace(plan.graph)
    # A graph keeps its blocks sorted; here they stand as no declaration can make them stand.
    object.__setattr__(graph, "blocks", MappingProxyType(dict(mixed(graph.blocks.items(), dice))))
    return dataclasses.replace(
        plan,
        graph=graph,
        schedule=dataclasses.replace(plan.schedule, order=tuple(order)),
        solvers=tuple(mixed(plan.solvers, dice)),
    )


def needs(flat: Graph) -> dict[OutputStep, set[OutputStep]]:
    """What has to be known before each output, from the definition: wires into the arguments of its function.

    Among them stand the constants of a block with driven parameters, which all outputs need that name them.
    """
    needed: dict[OutputStep, set[OutputStep]] = {
        (n, port): set() for n, block in flat.blocks.items() for port in type(block).outputs
    }
    for wire in flat.wires:
        source, (name, port) = split(wire.source), split(wire.target)
        block = flat.blocks[name]
        if port in type(block).parameters:
            needed.setdefault(ConstantsOf(name), set()).add(source)
        for output, behaviour in type(block).output_functions.items():
            if port in type(block).parameters and names_its_constants(behaviour.function):
                needed[name, output].add(ConstantsOf(name))
            elif port in behaviour.arguments:
                needed[name, output].add(source)
    return needed


@functools.cache
def names_its_constants(function: Callable[..., Any]) -> bool:
    """Whether the body of a function has the name of its first argument."""
    (tree,) = ast.parse(inspect.getsource(function)).body
    assert isinstance(tree, ast.FunctionDef)
    first = tree.args.args[0].arg
    return any(isinstance(node, ast.Name) and node.id == first for part in tree.body for node in ast.walk(part))


def legal_order(needed: Mapping[OutputStep, set[OutputStep]], dice: random.Random) -> list[OutputStep]:
    """One of all orders in which nothing comes before what it needs, by chance."""
    order: list[OutputStep] = []
    waiting = {node: set(before) for node, before in needed.items()}
    while waiting:
        node = dice.choice([node for node, before in waiting.items() if not before])
        order.append(node)
        del waiting[node]
        for before in waiting.values():
            before.discard(node)
    return order
