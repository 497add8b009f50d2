"""Graph == read(write(Graph)), exactly, for the library and for any graph."""

from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proofmass.blocks import PID, AnalogToDigital, Constant, DiscreteTransferFunction, Gain
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Probe, Wire
from proofmass.graphs.model.keys import BLOCK_KEYS, PART_KEYS
from proofmass.graphs.model.loops import Loop
from proofmass.graphs.model.rates import HIGHEST_RATE, LOWEST_RATE
from tests.by_hand.graph_texts import LIBRARY

names = st.from_regex(r"[a-z][a-z0-9]{0,9}(_[a-z0-9]{1,9}){0,3}", fullmatch=True)
signals = st.lists(names, min_size=2, max_size=4).map(".".join)
RESERVED = {*PART_KEYS, *BLOCK_KEYS}
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=30)
finite = st.floats(allow_nan=False, allow_infinity=False)
units = st.sampled_from(["1", "V", "mV", "kg*m^2", "N m s/rad", "nV/sqrt(Hz)", "%", "1/s", "µm", "(m/s^2)/V", "g0"])
rates = st.fractions(min_value=LOWEST_RATE, max_value=HIGHEST_RATE, max_denominator=10**12)
gains = st.builds(Gain, gain=finite, input_unit=units, output_unit=units)
constants = st.builds(Constant, value=finite, unit=units)
converters = st.builds(
    AnalogToDigital,
    bits=st.integers(2, 32),
    reference=st.floats(min_value=0.0, exclude_min=True, allow_infinity=False),
    offset_error=finite,
)
filters = st.builds(DiscreteTransferFunction, numerator=st.tuples(finite))
controllers = st.builds(PID, proportional=finite, limited=st.booleans(), input_unit=units, output_unit=units)
blocks = st.one_of(gains, constants, converters, filters, controllers)

asked = st.none() | st.floats(0.0, 1e6)
loops = st.builds(Loop, open_at=signals, gain_margin=asked, phase_margin=asked, delay_margin=asked)


@st.composite
def graphs(draw: st.DrawFn, depth: int = 0) -> Graph:
    chosen: dict[str, Block | Graph] = dict(draw(st.dictionaries(names, blocks, max_size=4)))
    if depth:
        chosen |= draw(st.dictionaries(names, graphs(depth - 1), max_size=2))
    length = draw(st.sampled_from(["duration", "samples", "neither"]))
    return Graph(
        name=draw(texts),
        description=draw(texts),
        rate=draw(st.none() | rates),
        duration=draw(st.fractions(0, 10**9, max_denominator=10**9)) if length == "duration" else None,
        samples=draw(st.integers(1, 10**12)) if length == "samples" else None,
        seed=draw(st.integers(0, 2**62)),
        blocks=chosen,
        rates={name: draw(rates) for name in chosen if draw(st.booleans())},
        wires=draw(st.lists(st.builds(Wire, signals, signals), max_size=3)),
        exports=draw(st.dictionaries(names.filter(lambda name: name not in RESERVED), signals, max_size=2)),
        loops=draw(st.dictionaries(signals | names, loops, max_size=2)),
        probes=draw(
            st.lists(st.builds(Probe, signals, st.integers(1, 10**12), st.sampled_from(["", "deg/h"])), max_size=3)
        ),
    )


def assert_same(graph: Graph) -> str:
    """The graph reads back, down to the sign of a zero; returns its text."""
    text = write_graph(graph)
    again = read_graph_text(text)
    assert again == graph
    assert repr(again) == repr(graph)
    assert write_graph(again) == text
    return text


@pytest.mark.exhaustive(but=35)
@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
@pytest.mark.friendly(17, "graphs of the library are written and read back")
def test_the_library_reads_back(path: Any) -> None:
    assert_same(read_graph(path))


@given(graphs())
@settings(max_examples=settings.default.max_examples // 5)
@pytest.mark.friendly(17, "so are random graphs")
def test_any_graph_reads_back(graph: Graph) -> None:
    assert_same(graph)


@given(graphs(depth=2))
@settings(max_examples=settings.default.max_examples // 12)
def test_any_graph_with_subgraphs_reads_back_and_its_flat_form_too(graph: Graph) -> None:
    assert_same(graph)
    flat = flatten(graph)
    assert_same(flat.as_graph())
    assert flatten(read_graph_text(write_graph(graph))) == flat
    assert len(flat.blocks) == graph.size.blocks


@pytest.mark.parametrize("kind", all_blocks().values(), ids=lambda kind: kind.__name__)
def test_every_block_reads_back(kind: type[Block]) -> None:
    assert_same(Graph(name="", blocks={"block": kind()}))


def test_what_a_file_looks_like() -> None:
    graph = Graph(
        name='the "first"',
        description="Two lines,\nthe second with a \\ and a\ttab.",
        rate="50 kHz",
        duration="1/3 s",
        seed=7,
        blocks={
            "adc": AnalogToDigital(bits=16, reference=50e-3, offset_error=-0.0),
            "gain": Gain(gain=2.5, input_unit="m", output_unit="V"),
            "pid": PID(limited=True, proportional=2),
            "one": Constant(value=200e-6, unit="1"),
        },
        rates={"adc": Fraction(9600, 1023)},
        wires=["gain.output -> adc.voltage"],
        probes=["adc.code", Probe("gain.output", 10)],
    )
    assert (
        assert_same(graph)
        == '''\
#:schema proofmass-graph.json
name = "the \\"first\\""
description = """
Two lines,
the second with a \\\\ and a\\U00000009tab."""
rate = "50 kHz"
duration = "1/3 s"
seed = 7

wires = [
    "gain.output -> adc.voltage",
]

probes = [
    "adc.code",
    { signal = "gain.output", every = 10 },
]

[blocks.adc]
kind = "AnalogToDigital"
rate = "3200/341 Hz"
bits = 16
reference = "0.05 V"
offset_error = -0.0

[blocks.gain]
kind = "Gain"
gain = "2.5 V/m"
input_unit = "m"
output_unit = "V"

[blocks.one]
kind = "Constant"
value = 0.0002

[blocks.pid]
kind = "PID"
proportional = 2.0
limited = true
'''
    )


def test_lists_are_written_in_their_own_unit() -> None:
    block = DiscreteTransferFunction(numerator=(0.1, 0.2), denominator=(1, -0.5))
    text = assert_same(Graph(name="", blocks={"filter": block}))
    assert "numerator = [0.1, 0.2]\n" in text


def test_a_unit_too_long_for_a_quantity_is_left_to_the_block() -> None:
    unit = "*".join(["kg/kg"] * 32) + "*V"
    text = assert_same(Graph(name="", blocks={"long": Constant(value=0.1 + 0.2, unit=unit)}))
    assert "value = 0.30000000000000004\n" in text


def test_quantities_in_base_units_unless_they_are_to_stay_as_written() -> None:
    """The one form is for comparisons, the other for people."""
    graph = read_graph_text(
        'name = "a"\nrate = "1 kHz"\nduration = "5 ms"\n[blocks.one]\nkind = "Constant"\nvalue = "3 mV"\nunit = "V"\n'
    )
    plain, written = write_graph(graph), write_graph(graph, as_written=True)
    assert 'duration = "1/200 s"\n' in plain
    assert 'value = "0.003 V"\n' in plain
    assert 'duration = "5 ms"\n' in written
    assert 'value = "3 mV"\n' in written
