"""Measures of a graph: read, written, carried along, and refused with the place and the nearest name."""

import copy
import dataclasses

import pytest

from proofmass.blocks import AnalogToDigital, Constant, Correlator, ShiftRegister
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.measures import Measure
from proofmass.graphs.model.statistics import STATISTICS
from tests.by_hand.graph_texts import SMALL, line_of, problems_of

MEASURED = (
    SMALL + '\n[measures]\nbias = { signal = "adc.code", statistic = "mean", from = "0.5 s" }\n'
    'noise = { signal = "readout.output", statistic = "std" }\n'
    'high = { signal = "readout.output", statistic = "percentile", percent = 99 }\n'
    'drift = { signal = "readout.output", statistic = "allan_deviation", tau = "100 ms" }\n'
    'ready = { signal = "readout.output", statistic = "settling_time", target = "1 V", within = "1 mV" }\n'
)


def test_they_are_read_written_copied_and_made_flat() -> None:
    graph = read_graph_text(MEASURED)
    assert graph.measures["bias"] == Measure("adc.code", "mean", graph.duration / 2)  # type: ignore[operator]
    assert read_graph_text(write_graph(graph)) == graph
    assert copy.deepcopy(graph) == graph
    outer = Graph(
        name="outer",
        rate=10,
        blocks={"axis": dataclasses.replace(graph, exports={"code": "adc.code"})},
        measures={"bias": {"signal": "axis.code", "statistic": "last"}},
    )
    assert flatten(outer).measures == {"bias": Measure("axis.adc.code", "last")}


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ('statistic = "mean"', 'statistic = "maen"', "measures.bias.statistic", "did you mean mean?"),
        ('signal = "adc.code"', 'signal = "adc.cod"', "measures.bias.signal", "did you mean code?"),
        ('signal = "adc.code"', 'signal = "acd.code"', "measures.bias.signal", "did you mean adc?"),
        ('signal = "adc.code"', 'signal = "adc"', "measures.bias.signal", "block.output"),
        ('from = "0.5 s"', 'form = "0.5 s"', "measures.bias.form", "did you mean from?"),
        ('from = "0.5 s"', 'from = "0.5 V"', "measures.bias.from", "s"),
        (', statistic = "mean"', "", "measures.bias", "has no statistic"),
        ("bias =", "Bias =", "measures.Bias", "lower-case"),
        (", percent = 99", "", "measures.high", "percentile needs percent"),
        ("percent = 99", "percent = 100", "measures.high.percent", "< 100"),
        ("percent = 99", 'percent = "99 V"', "measures.high.percent", "99 V"),
        ("percent = 99", "percent = 99, tau = 1", "measures.high.tau", "percentile has no tau"),
        ('tau = "100 ms"', 'tau = "100 mV"', "measures.drift.tau", "s"),
        ('within = "1 mV"', 'within = "1 mA"', "measures.ready.within", "1 mA"),
    ],
)
def test_mistakes_are_said_with_line_key_and_nearest_name(old: str, new: str, key: str, said: str) -> None:
    text = MEASURED.replace(old, new)
    (problem,) = problems_of(text)
    assert (problem.file, problem.key) == ("model.toml", key)
    assert problem.line == line_of(MEASURED, old)
    assert said in str(problem)


def test_a_vector_and_a_taken_name_are_refused() -> None:
    correlated = Graph(
        name="cells",
        rate=10,
        blocks={
            "register": ShiftRegister(),
            "adc": AnalogToDigital(),
            "zero": Constant(unit="V"),
            "cells": Correlator(),
        },
        wires=["register.bit -> cells.bit", "zero.output -> adc.voltage", "adc.code -> cells.code"],
        measures={"bias": {"signal": "cells.impulse_response", "statistic": "mean"}},
    )
    assert "a vector cannot be measured" in [problem.message for problem in check(correlated)]
    taken = [problem.message for problem in problems_of(MEASURED.replace("adc", "measures"))]
    assert taken == ["the name is taken where a graph has measures"]


def test_every_statistic_has_a_block_with_that_output() -> None:
    for name, statistic in STATISTICS.items():
        assert name == "last" if statistic.block is None else statistic.output in statistic.block.outputs
