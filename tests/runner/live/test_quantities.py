"""Quantities as files have them: the page and the process write the same digits, which are read back to the bit."""

import json
import random
import subprocess
from fractions import Fraction
from typing import Any

import pytest

from proofmass.blocks.declaration.spelled_units import decimal_in, spellings
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import convert
from tests.by_hand.live_node import MODULES
from tests.by_hand.node import NODE, needs_node

_SCRIPT = """
import fs from 'fs';
const {module, texts, quantities} = JSON.parse(fs.readFileSync(0));
const {textIn, quantity, nearest} = await import(module);
const read = ([text, shown, factor, spelled]) => {
  const made = quantity(text, shown, factor, spelled);
  return typeof made === 'string' ? made : nearest(made);
};
const answers = {texts: texts.map(([value, factor]) => textIn(value, factor)), numbers: quantities.map(read)};
process.stdout.write(JSON.stringify(answers));
"""


def asked(texts: list[Any], quantities: list[Any]) -> dict[str, list[Any]]:
    told = {"module": (MODULES / "quantities.mjs").resolve().as_uri(), "texts": texts, "quantities": quantities}
    command = [NODE or "", "--input-type=module", "--eval", _SCRIPT]
    done = subprocess.run(command, input=json.dumps(told), capture_output=True, text=True, check=True)
    answers: dict[str, list[Any]] = json.loads(done.stdout)
    return answers


def exact(factor: Fraction) -> list[str]:
    return [str(part) for part in factor.as_integer_ratio()]


def forms(own: str) -> list[dict[str, Any]]:
    return [
        {"form": form, "names": [{name: exact(factor) for name, factor in one.items()} for one in names]}
        for form, names in spellings(own)
    ]


@pytest.mark.exhaustive
@needs_node
def test_page_and_process_write_the_same_digits_which_are_read_back() -> None:
    """Random floats over 60 decades and awkward ones, in units with decimal, odd and irrational factors."""
    drawn = random.Random(4)
    values = [drawn.choice((-1, 1)) * drawn.uniform(1, 10) * 10.0 ** drawn.randint(-30, 30) for _ in range(150)]
    values += [round(value, 3) for value in values[:50]]
    values += [0.0, 1.0, 1e22, 1e23, 1e-290, 1.25e290, 0.1 + 0.2, 9.80665, 2.0**-900, 123456789012.0]
    factors = [unit(text).factor for text in ("1", "ug", "g0", "deg", "V/um", "year", "nV/sqrt(kHz)")]
    cases = [(value, factor) for value in values for factor in factors]
    texts = asked([[value, exact(factor)] for value, factor in cases], [])["texts"]
    assert texts == [decimal_in(value, factor) for value, factor in cases]
    assert all(float(Fraction(text) * factor) == value for text, (value, factor) in zip(texts, cases, strict=True))


@needs_node
@pytest.mark.parametrize(
    ("shown", "texts"),
    [
        ("V/um", ["20", "3 mV/nm", "1e3 V/mm", "2.5e-3kV/um"]),
        ("g0", ["1", "250 mg0"]),
        ("1/s", ["6.5 kHz", "3", "7 1/ms"]),
        ("(m/s^2)/sqrt(Hz)", ["1", "2 (mm/s^2)/sqrt(Hz)", "2 (m/s^2)/sqrt(kHz)"]),
        ("1", ["0.1", "3 %", "20 ppm", "−4 deg"]),
    ],
)
def test_a_field_reads_what_a_file_reads(shown: str, texts: list[str]) -> None:
    factor = unit(shown).factor
    own = {"(m/s^2)/sqrt(Hz)": "(m/s^2)/sqrt(Hz)"}.get(shown) or unit(shown).in_base_units()
    read = asked([], [[text, shown, exact(factor), forms(shown)] for text in texts])["numbers"]
    plain = [text.replace("−", "-") for text in texts]
    assert read == [convert(text if text.strip("-+.e0123456789") else f"{text} {shown}", own) for text in plain]


@needs_node
def test_a_field_says_what_it_does_not_read() -> None:
    given = ["", "two", "1..2", "3 kg", "3 V/kg", "1 sqrt(V)/um"]
    read = asked([], [[text, "V/um", ["1000000", "1"], forms("V/um")] for text in given])["numbers"]
    assert read[:3] == ["is not a number"] * 3
    assert read[3:] == [f"has the unit {unit}: write it in V/um" for unit in ("kg", "V/kg", "sqrt(V)/um")]


@pytest.mark.defect("S917", before="2 kHz in a field of rad/s were 2000 rad/s", after="no spelling of it")
def test_a_field_of_angles_takes_no_turns() -> None:
    assert [form for form, _ in spellings("rad/s")] == ["?/?"]
    assert [form for form, _ in spellings("Hz")] == ["?"]
