"""Notes on choppers: where a demodulator reads a tick late, and where it does not."""

import pytest

from proofmass.graphs.checks.check import check
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.runner.run.simulate import simulate

TEXT = """\
name = "chopped amplifier"
rate = "400 kHz"
duration = "20 ms"
wires = [
    "source.output -> chop.input",
    "chop.output -> pole.input",
    "pole.output -> unchop.input",
    "unchop.output -> slow.input",
]
probes = ["slow.output"]
measures = { gain = { signal = "unchop.output", statistic = "mean", from = "10 ms" } }
[blocks]
source = { kind = "Constant", value = 1, unit = "V" }
chop = { kind = "ChopperModulator", half_period = HALF }
pole = { kind = "LowPass", corner_frequency = "20 MHz", input_unit = "V", output_unit = "V" }
unchop = { kind = "ChopperModulator", half_period = HALF }
slow = { kind = "LowPass", corner_frequency = "200 Hz", input_unit = "V", output_unit = "V" }
"""
GAIN = 'kind = "LowPass", corner_frequency = "20 MHz"', 'kind = "Gain"'


def notes(text: str) -> list[str]:
    return [
        str(problem) for problem in check(read_graph_text(text, "graph.toml")) if "before the switch" in str(problem)
    ]


@pytest.mark.defect(
    "S657", before="check says nothing of a chopper with a gain of 1/2 where 1 is meant", after="a note with the gain"
)
@pytest.mark.parametrize("half", [4, 10])
def test_a_pole_between_modulator_and_demodulator(half: int) -> None:
    """Far above the rate the pole is one tick late: of `half` ticks one counts negative."""
    text = TEXT.replace("HALF", str(half))
    graph = read_graph_text(text)
    found = simulate(graph, engine="python").measures["gain"].value
    assert found == pytest.approx(1.0 - 2.0 / half, abs=0.001)
    (note,) = notes(text)
    assert "note" in note
    assert "unchop" in note
    assert f"at most {found:.1g}" in note
    assert f"graph.toml:{1 + text[: text.index('unchop = {')].count(chr(10))}" in note


def test_what_is_read_in_the_same_tick_has_no_note() -> None:
    text = TEXT.replace("HALF", "4")
    assert simulate(read_graph_text(text.replace(*GAIN)), engine="python").measures["gain"].value == 1.0
    assert not notes(text.replace(*GAIN))
    assert not notes(TEXT.replace("HALF", "4", 1).replace("HALF", "6"))  # other periods: no pair
    assert not [
        problem
        for problem in check(read_graph(library_file("chopped_accelerometer.toml")))
        if "before the switch" in str(problem)
    ]


def test_a_second_chain_starts_with_a_modulator() -> None:
    """After the slow filter the signal is not chopped any more."""
    chain = (
        TEXT.replace(*GAIN)
        .replace("HALF", "4")
        .replace('"unchop.output -> slow.input",', '"unchop.output -> slow.input", "slow.output -> again.input",')
    )
    chain += 'again = { kind = "ChopperModulator", half_period = 4 }\n'
    assert not notes(chain)


@pytest.mark.exhaustive
def test_the_way_out_that_the_hint_names() -> None:
    text = TEXT.replace("HALF", "4").replace('"pole.output -> unchop.input",', '"pole.output -> unchop.first",')
    text = text.replace("wires = [", 'wires = [\n    "chop.square -> late.input",\n    "late.output -> unchop.second",')
    text = text.replace('unchop = { kind = "ChopperModulator", half_period = 4 }', (
        'unchop = { kind = "Product", first_unit = "V" }\nlate = { kind = "UnitDelay" }'
    ))  # fmt: skip
    graph = read_graph_text(text)
    assert not notes(text)
    assert simulate(graph, engine="python").measures["gain"].value == pytest.approx(1.0, abs=0.001)
