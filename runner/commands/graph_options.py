"""The graph that a command works on: a file, with what `--blocks`, `--set` and `--probe` say."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from proofmass.blocks.declaration.problem import Problem, Refusal
from proofmass.graphs.files.toml_reader import read_graph, read_table
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.graph import Graph, Probe, split
from proofmass.graphs.model.integration import read_integration
from proofmass.graphs.model.names import Missing, find_output, last_outputs
from proofmass.graphs.model.targets import DURATION, RATE
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import STUDY, is_study, read_variants
from proofmass.runner.commands.named_options import by_name
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.swept_values import value_of


def graph_of(path: Path, own: Path | None, changes: tuple[str, ...] = (), probes: tuple[str, ...] = ()) -> Graph:
    """Return the graph of a file with its options; raises `ModelError` or `click.UsageError`."""
    graph = changed(read_graph(path, own_blocks(own)), changes)
    return graph.changed(probes=(*graph.probes, *_new_probes(graph, probes)))


def toleranced(path: Path, own: Path | None, changes: tuple[str, ...]) -> tuple[Graph | Study, dict[str, str]]:
    """Return the graph of a file, or the study in it, whose spread counts as tolerances; raises as `graph_of` does.

    Of variants it is the first, with why the others do not count.
    """
    data, _ = read_table(path)
    if not is_study(data) and STUDY not in data:
        return graph_of(path, own, changes), {}
    (first, study), *others = read_variants(path, own_blocks(own), lambda graph: changed(graph, changes)).items()
    return study, {name: f"it is a variant of its own, and {first} is looked at" for name, _ in others}


def changed(graph: Graph, changes: tuple[str, ...]) -> Graph:
    """Return the graph with what `--set` says; raises `ModelError` or `click.UsageError`."""
    values = by_name("--set", [_change(graph, text) for text in changes])
    if "integration" not in (*graph.blocks, *graph.subgraphs):
        whole = "integration."
        steps = {key.removeprefix(whole): values.pop(key) for key in tuple(values) if key.startswith(whole)}
        if steps:
            graph = graph.changed(integration=read_integration(graph.integration.changed() | steps))
    return with_parameters(graph, values) if values else graph


def _change(graph: Graph, text: str) -> tuple[str, Any]:
    """Key and value of one `--set`."""
    key, equals, value = text.partition("=")
    key = key.strip()
    if not equals or ("." not in key and not graph.values and key not in (RATE, DURATION)):
        owner = next((name for name, block in graph.blocks.items() if key in type(block).parameters), "")
        example = f"{owner}.{key}={value.strip() or 'VALUE'}" if owner else "adc.reference=5V"
        raise click.UsageError(f"--set {text}: write BLOCK.PARAMETER=VALUE, for example {example}")
    driver = next((wire.source for wire in graph.wires if wire.target == key), "")
    if driver:
        message = f"is driven by {driver}: a value would change nothing"
        raise Problem(message=message, key=key, hint=f"change {split(driver)[0]}, or remove the wire").error
    return key, value_of(value)


def _new_probes(graph: Graph, signals: tuple[str, ...]) -> Iterator[Probe]:
    probed = {probe.signal for probe in graph.probes}
    flat = flatten(graph) if signals else None
    for signal in dict.fromkeys(signals):
        try:
            probe = read_probe(signal)
        except Refusal:
            raise click.UsageError(f"--probe {signal}: write BLOCK.PORT, for example adc.code") from None
        known = find_output(flat, inside(graph, signal)) if flat is not None else None
        if isinstance(known, Missing):
            raise Problem(message=known.message, key=f"--probe {signal}", hint=known.hint).error
        if signal not in probed:
            yield probe


def outputs_of(graph: Graph, named: str, option: str) -> list[str]:
    """Return the output named, else probes, else outputs nothing reads; raises `ModelError`."""
    probed = dict.fromkeys(probe.signal for probe in graph.probes)
    outputs = [named] if named else list(probed) or last_outputs(flatten(graph))
    if not outputs:
        hint = f"name an output: {option} adc.number"
        raise graph.placed(Problem(message="the graph has no probe", hint=hint, path=("probes",))).error
    return outputs
