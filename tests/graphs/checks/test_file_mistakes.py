"""Mistakes in files that a hint cures by the very line to write."""

import re

import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.rates import read_rate, write_rate
from proofmass.graphs.studies.study_reader import read_study_text
from tests.by_hand.graph_texts import LIBRARY, check_text, problems_of

TEMPLATE = library_file("template.toml").read_text(encoding="utf-8")
SLOW = ("bits = 16", 'bits = 16\nrate = "7 kHz"')
FAST = ('rate = "10 kHz"', 'rate = "50 kHz"')


def said(*changes: tuple[str, str]) -> list[str]:
    text = TEMPLATE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return [str(problem) for problem in problems_of(text)]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"inertia.output -> sensor.force"', '"inertia -> sensor"', 'hint:     write "inertia.output -> sensor.force"'),
        ('"sensor.displacement -> readout.input"', '"sensor -> readout"', '"sensor.displacement -> readout.input"'),
        ('"readout.output -> adc.voltage"', '"readout.output -> adc"', 'write "readout.output -> adc.voltage"'),
        ("inertia.output -> sensor.force", "sensor.force -> inertia.output", 'write "inertia.output -> sensor.force"'),
        ("[blocks.readout]", "[blocks.sensor]", "blocks.sensor is given twice, in lines 27 and 33"),
        ("bits = 16", "bits = 16\nbits = 12", "blocks.adc.bits is given twice, in lines 41 and 42"),
        ("bits = 16", "bits = 16\nlimited = True", "TOML writes true and false in lower case: limited = true"),
        ("49.5627 N/m", "3.16 Nr/m", "did you mean N/m?"),
        ("3.53e8 V/m", "20 V/u", "did you mean V/um?"),
        ("1 g0", "20 gu", "did you mean g0?"),
        ("3.4e-3 kg/s", "3.4e-3 Kg/s", "did you mean kg/s?"),
        ("50.43 ug", "50 mgr", "did you mean mg?"),
        ("90 Hz", "90 hz", "did you mean Hz?"),
        ('input_unit = "m"\n', "", 'set input_unit = "m"'),
        ('input_unit = "m"\noutput_unit = "V"\n', "", 'set output_unit = "V" and input_unit = "m"'),
    ],
)  # fmt: skip
def test_a_hint_is_what_to_write(old: str, new: str, words: str) -> None:
    told = said((old, new))
    assert len(told) == 1
    assert words in told[0]


def test_a_misspelt_kind_hides_no_fault_at_the_other_end_of_its_wires() -> None:
    told = said(
        ('kind = "Gain"\ngain = "50.43e-9', 'kind = "Gian"\ngain = "50.43e-9'), ("-> sensor.force", "-> sensor.forc")
    )
    assert len(told) == 2
    assert "sensor.forc is neither an input nor a parameter" in told[0]


def test_a_unit_that_is_a_parameter_is_named() -> None:
    told = said(
        ("[blocks.adc]", '[blocks.minus]\nkind = "Negation"\nunit = "m"\n\n[blocks.adc]'),
        ('"readout.output -> adc.voltage"', '"readout.output -> minus.input", "minus.output -> adc.voltage"'),
    )
    assert len(told) == 2
    assert all('set unit = "V" under [blocks.minus], or put a Gain' in problem for problem in told)


def test_rates_that_meet_far_above_are_noted() -> None:
    (note,) = check_text(TEMPLATE.replace(*FAST).replace(*SLOW)).problems
    assert note.note
    assert note.message == "the rates meet only at 350 kHz, the base rate of a run"
    assert note.hint == "that is 7 times the ticks; 6.25 kHz would keep 50 kHz"
    assert not check_text(TEMPLATE.replace(*FAST).replace(*SLOW).replace("7 kHz", "6.25 kHz")).problems


@pytest.mark.parametrize(
    ("fastest", "odd", "kept"),
    [
        ("50 kHz", "7 kHz", "6.25 kHz"),
        ("50 kHz", "30 kHz", "25 kHz"),  # not 50/3 kHz, which is nearer, but long
        ("6981.1 Hz", "418.866 Hz", "69811/170 Hz"),  # 997.3 Hz is short, and more than twice as much
    ],
)
def test_the_rate_that_is_offered_is_near_and_divides_the_fastest(fastest: str, odd: str, kept: str) -> None:
    text = TEMPLATE.replace(*FAST).replace(*SLOW).replace("50 kHz", fastest).replace("7 kHz", odd)
    (note,) = check_text(text).problems
    assert note.hint.endswith(f"; {kept} would keep {write_rate(read_rate(fastest))}")
    assert (read_rate(fastest) / read_rate(kept)).denominator == 1
    assert 0.5 <= read_rate(kept) / read_rate(odd) <= 2.0


@pytest.mark.exhaustive
def test_the_library_has_no_rates_that_meet_far_above() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in LIBRARY}
    notes = [p for path, text in texts.items() for p in check_text(text, str(path), folder=str(path.parent)).problems]
    assert not [note for note in notes if "the base rate of a run" in note.message]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('[spread]\n"adc.reference" = { gaussian = "1 mV" }', "here that is normal"),
        ('[spread]\n"adc.reference" = { sigma = "1 mV" }', "here that is normal"),
        ('[epochs]\nages = ["10 year", "1 year"]', 'write ages = ["1 year", "10 year"]'),
        ("[epochs]\nages = [0, 5, 1]", "write ages = [0, 1, 5]"),
        ('[epochs]\nages = ["10 year", "soon", "1 year"]', 'write ages = ["1 year", "10 year"]'),
    ],
)
def test_a_study_is_answered_by_what_to_write(table: str, words: str) -> None:
    text = f'graph = "library:closed_loop_accelerometer.toml"\nruns = 4\nmargins = "0 s"\n{table}\n'
    wrong = check_text(text).problems
    assert words in wrong[-1].hint
    assert read_study_text(text.partition("[")[0]).runs == 4


@pytest.mark.parametrize(("word", "statistic"), [("average", "mean"), ("sigma", "std"), ("p2p", "peak_to_peak")])
def test_a_statistic_is_known_by_other_names(word: str, statistic: str) -> None:
    measures = f'[measures]\nm = {{ signal = "adc.code", statistic = "{word}" }}\n'
    (told,) = said(("[blocks.adc]", f"{measures}\n[blocks.adc]"))
    assert re.search(rf"hint: +here that is {statistic}$", told)
