"""Measures until a time: every statistic is that of a run which ends there, in all engines."""

from fractions import Fraction

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.graphs.studies.build import Study
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import run_study

OPTIONS = {
    "percentile": ", percent = 80",
    "allan_deviation": ', tau = "10 ms"',
    "settling_time": ", target = 0, within = 1.5",
    "tone_amplitude": ', frequency = "50 Hz"',
    "tone_phase": ', frequency = "50 Hz"',
    "band_rms": ', low = "10 Hz", high = "100 Hz"',
    "density": ', frequency = "100 Hz", segment = "32 ms"',
}
FROM = ', from = "20 ms"'
MEASURES = "\n".join(
    f'{name} = {{ signal = "sum.output", statistic = "{name}"{FROM if row.block else ""}, '
    f'until = "200 ms"{OPTIONS.get(name, "")} }}'
    for name, row in STATISTICS.items()
)
TEXT = f"""\
name = "noise on a tone that stops mattering"
rate = "1 kHz"
samples = 500
wires = ["tone.output -> sum.first", "noise.output -> sum.second"]
[measures]
{MEASURES}
[blocks]
tone = {{ kind = "Sine", frequency = "50 Hz" }}
noise = {{ kind = "WhiteNoise", density = "0.02 1/sqrt(Hz)" }}
sum = {{ kind = "Sum" }}
"""
PLAIN = TEXT.replace(', until = "200 ms"', "")


@pytest.mark.exhaustive
def test_every_statistic_is_that_of_a_run_which_ends_there() -> None:
    whole, short = read_graph_text(TEXT), read_graph_text(PLAIN)
    for engine in ("python", "compiled"):
        expected = simulate(short, samples=200, engine=engine).measures
        longer = simulate(short, samples=500, engine=engine).measures
        for samples in (200, 201, 500):
            found = simulate(whole, samples=samples, engine=engine).measures
            assert {n: m.value for n, m in found.items()} == {n: m.value for n, m in expected.items()}
        assert sum(longer[name].value != expected[name].value for name in expected) > len(expected) // 2


@pytest.mark.exhaustive
def test_studies_have_them_in_lanes() -> None:
    study = Study(read_graph_text(TEXT), runs=5, spread={"tone.amplitude": {"normal": 0.1}})
    python = run_study(study, engine="python")
    assert run_study(study, engine="compiled", lanes=4).digest == python.digest


def test_it_is_written_and_read_again() -> None:
    graph = read_graph_text(TEXT)
    assert graph.measures["mean"].until == Fraction(1, 5)
    assert read_graph_text(write_graph(graph)).measures == graph.measures


@pytest.mark.parametrize(
    ("until", "said"),
    [('"20 ms"', "ends before it begins"), ('"soon"', "measures.mean.until"), ('"20.1 ms"', ""), ("0", "before it")],
)
def test_a_wrong_time_is_refused(until: str, said: str) -> None:
    line = 'mean = { signal = "sum.output", statistic = "mean", from = "20 ms", until = '
    text = TEXT.replace(line + '"200 ms"', line + until)
    assert text != TEXT
    if not said:
        assert simulate(read_graph_text(text)).measures["mean"].value != 0.0
        return
    with pytest.raises(ModelError) as caught:
        read_graph_text(text)
    assert said in str(caught.value)


def test_too_few_samples_are_refused() -> None:
    line = 'allan_deviation = { signal = "sum.output", statistic = "allan_deviation", from = "20 ms", until = '
    with pytest.raises(ModelError, match="too short"):
        simulate(read_graph_text(TEXT.replace(line + '"200 ms"', line + '"30 ms"')))


@pytest.mark.defect(
    "S708",
    before="a value that moved the begin of a measure past its end was refused with the end as Fraction(1, 50)",
    after="the end is named as 20 ms",
)
def test_a_value_that_moves_the_begin_past_the_end_is_refused() -> None:
    text = 'rate = "1 kHz"\n[values]\nsettling = "10 ms"\n[blocks.a]\nkind = "Constant"\n[measures]\n'
    text += 'mean = { signal = "a.output", statistic = "mean", from = "= settling", until = "20 ms" }\n'
    graph = read_graph_text(text)
    assert graph.with_parameters({"settling": "15 ms"}).measures["mean"].start == Fraction(15, 1000)
    with pytest.raises(ModelError) as caught:
        graph.with_parameters({"settling": "30 ms"})
    assert str(caught.value) == (
        "measures.mean.until: ends before it begins\n  got:      20 ms\n  expected: after from"
    )
