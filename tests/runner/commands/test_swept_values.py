"""Values of `--sweep`: lists, ranges by hand, and what is refused."""

import click
import pytest

from proofmass.runner.commands.swept_values import sweeps


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("10,12,14", [10, 12, 14]),
        ("1V, 2V", ["1V", "2V"]),
        ("8:12:5", [8, 9, 10, 11, 12]),
        ("1:0:3", [1, 0.5, 0]),
        ("1mV:1V:3", ["1.0 mV", "500.5 mV", "1000.0 mV"]),
        ("-2:-8:3:log", [-2, -4, -8]),
        ("1Hz:10kHz:5:log,20kHz", ["1.0 Hz", "10.0 Hz", "100.0 Hz", "1000.0 Hz", "10000.0 Hz", "20kHz"]),
        ("1g:1kg:4:log", ["1.0 g", "10.0 g", "100.0 g", "1000.0 g"]),
        ("data:part:a.csv", ["data:part:a.csv"]),
    ],
)
def test_lists_and_ranges(text: str, values: list[object]) -> None:
    assert sweeps((f"adc.key={text}",)) == {"adc.key": values}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1V:2A:3", "A is"),
        ("0:10:3:log", "logarithmic steps need two ends above zero"),
        ("1:2:1", "a range has 2 to 10000 values, not 1"),
        ("", "write NAME=VALUE,VALUE"),
        pytest.param(
            "1e-400:1:3",
            "too small for a number",
            marks=pytest.mark.defect("S1047", before="a range from 1e-400 began at 0", after="refused"),
        ),
        pytest.param(
            "1 V:1e400 V:3",
            "too large for a number",
            marks=pytest.mark.defect("C894", before="OverflowError", after="refused"),
        ),
        pytest.param(
            "1e-300:1e300:3:log",
            "more than 300 decades",
            marks=pytest.mark.defect("C895", before="OverflowError, or zeros between", after="refused"),
        ),
        ("1e300:1e-300:3:log", "more than 300 decades"),
    ],
)
def test_what_is_no_range(text: str, message: str) -> None:
    with pytest.raises(click.UsageError, match=message):
        sweeps((f"adc.key={text}",))


@pytest.mark.defect("S217", before="the values given first were dropped", after="refused")
def test_one_key_twice() -> None:
    with pytest.raises(click.UsageError, match=r"adc\.bits is given twice"):
        sweeps(("adc.bits=10", "adc.bits = 12,14"))
