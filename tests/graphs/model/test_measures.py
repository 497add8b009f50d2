"""Measures of a graph: read, written, carried along, and refused with the place and the nearest name."""

import copy
import dataclasses
from fractions import Fraction

import pytest

from proofmass.blocks import AnalogToDigital, Constant, Correlator, ShiftRegister
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.measures import Measure
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.run.simulate import simulate
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


FOLLOWING = """
name = "measures that follow"
rate = "1 kHz"
duration = "200 ms"
probes = ["tone.output"]
[values]
begin = "50 ms"
f0 = "100 Hz"
level = "250 mV"
part = 90
[blocks.tone]
kind = "Sine"
amplitude = "= level"
frequency = "= f0"
unit = "V"
[measures]
late = { signal = "tone.output", statistic = "mean", from = "= begin", until = "= 3 * begin" }
line = { signal = "tone.output", statistic = "tone_amplitude", frequency = "= f0", from = "= begin" }
high = { signal = "tone.output", statistic = "percentile", percent = "= part" }
ready = { signal = "tone.output", statistic = "settling_time", target = "= level / 2", within = "= 2 * level" }
drift = { signal = "tone.output", statistic = "allan_deviation", tau = "= begin / 10" }
"""
AS_NUMBERS = {"begin": "50 ms", "3 * begin": "150 ms", "part": "90", "f0": "100 Hz", "level / 2": "125 mV"}
AS_NUMBERS |= {"2 * level": "500 mV", "begin / 10": "5 ms"}


def test_they_follow_named_values() -> None:
    graph = read_graph_text(FOLLOWING)
    assert graph.measures["late"] == Measure("tone.output", "mean", Fraction(1, 20), (), Fraction(3, 20))
    assert dict(graph.measures["drift"].options) == {"tau": Fraction(1, 200)}
    assert read_graph_text(write_graph(graph)) == graph
    assert copy.deepcopy(graph) == graph
    numbers = FOLLOWING
    for formula, number in AS_NUMBERS.items():
        numbers = numbers.replace(f'"= {formula}"', f'"{number}"')
    assert numbers.count("= 1") == 0
    same = simulate(read_graph_text(numbers), engine="python").measures
    measured = simulate(graph, engine="python").measures
    assert {name: measure.value for name, measure in measured.items()} == {name: same[name].value for name in measured}
    assert measured["line"].value == pytest.approx(0.25)


def test_they_move_with_the_values() -> None:
    graph = read_graph_text(FOLLOWING).with_parameters({"begin": "20 ms", "f0": "150 Hz", "part": 50})
    assert (graph.measures["late"].start, graph.measures["late"].until) == (Fraction(1, 50), Fraction(3, 50))
    assert dict(graph.measures["line"].options) == {"frequency": "150.0 Hz"}
    assert dict(graph.measures["high"].options) == {"percent": 50.0}
    with pytest.raises(ModelError, match="must be at least zero"):
        graph.with_parameters({"begin": "-1 s"})


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        ('until = "= 3 * begin"', 'until = "= f0"', "measures.late.until", "is 1/s, not s"),
        ('until = "= 3 * begin"', 'until = "= begin / 2"', "measures.late.until", "= begin / 2"),
        ('tau = "= begin / 10"', 'tau = "= bgin"', "measures.drift.tau", "did you mean begin"),
        ('percent = "= part"', 'percent = "= part * 2"', "measures.high.percent", "< 100"),
        ('statistic = "mean", from', 'statistic = "= begin", from', "measures.late.statistic", "no such statistic"),
        ('begin = "50 ms"', 'begin = "50 mms"', "values.begin", "mms"),
    ],
)
def test_formulas_that_give_no_time_or_number_are_refused(old: str, new: str, key: str, said: str) -> None:
    (problem,) = problems_of(FOLLOWING.replace(old, new))
    assert problem.key == key
    assert problem.line == line_of(FOLLOWING, old)
    assert said in str(problem)


def test_a_formula_of_no_measure_is_refused() -> None:
    with pytest.raises(ModelError, match="did you mean late"):
        read_graph_text(FOLLOWING + '[formulas]\n"measures.lat.from" = "= begin"\n')


def test_no_run_of_a_study_varies_what_a_measure_follows() -> None:
    study = '[study]\nruns = 2\n[study.spread]\nlevel = { normal = "1 mV" }\n'
    with pytest.raises(ModelError, match=r"measures\.ready\.target follows from it, and cannot vary"):
        read_study_text(FOLLOWING + study)
