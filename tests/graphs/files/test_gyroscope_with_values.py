"""A gyroscope of 51 blocks, as a new user wrote it and with named values: the same numbers, in one place each."""

from pathlib import Path

import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.flatten import FlatGraph, flatten

FOLDER = Path(__file__).parent / "gyroscope"
PLAIN, NAMED = (read_graph(FOLDER / f"{name}.toml") for name in ("plain", "with_values"))


def parameters(flat: FlatGraph) -> dict[str, object]:
    return {f"{n}.{p}": getattr(b, p) for n, b in flat.blocks.items() for p in type(b).parameters}


def test_the_numbers_are_the_same() -> None:
    plain, named = flatten(PLAIN), flatten(NAMED)
    assert parameters(named) == parameters(plain)
    assert (named.rate, named.wires, named.probes, named.measures) == (
        plain.rate, plain.wires, plain.probes, plain.measures)  # fmt: skip
    assert {name: rate for name, rate in named.rates.items() if rate != 200_000} == {
        name: rate for name, rate in plain.rates.items() if rate != 200_000
    }


@pytest.mark.parametrize(
    ("change", "moved"),
    [
        ({"mass": "60 ug"}, ["coriolis.mass", "coriolis_back.mass", "drive.mass", "sense.mass"]),
        ({"delay": "9 deg"}, [
            "drive_carrier.angle.value", "quadrature_carrier.angle.value", "rate_carrier.angle.value"]),
        ({"sense_damping": "1e-6 kg/s"}, ["brownian.damping", "sense.damping"]),
        ({"carrier": "10 kHz"}, [
            *(f"{carrier}.oscillator.frequency" for carrier in (
                "cosine", "drive_carrier", "quadrature_carrier", "quadrature_demodulation", "rate_carrier",
                "rate_demodulation")),
            "sine.frequency",
        ]),
    ],
    ids=["mass", "delay", "damping", "carrier"],
)  # fmt: skip
def test_one_line_moves_all_that_follows(change: dict[str, str], moved: list[str]) -> None:
    before, after = parameters(flatten(NAMED)), parameters(flatten(NAMED.with_parameters(change)))
    assert sorted(name for name in before if before[name] != after[name]) == moved


def test_the_rates_follow_the_carrier() -> None:
    flat = flatten(NAMED.with_parameters({"carrier": "10 kHz"}))
    assert flat.rate == 250_000
    assert {flat.rates[name] for name in ("agc", "loop_filter", "rate_controller", "quadrature_controller")} == {10_000}


def test_it_reads_back(tmp_path: Path) -> None:
    text = write_graph(NAMED)
    (tmp_path / "again.toml").write_text(text)
    again = read_graph(tmp_path / "again.toml")
    assert again == NAMED
    assert write_graph(again) == text
