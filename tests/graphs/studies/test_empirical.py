"""A measured lot as a distribution: its values, its units, and files that cannot be one."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.counter_random import uniform_deviate
from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.studies.distributions import read_spread
from proofmass.graphs.studies.empirical import read_column

LOT = "device, offset [mV], gain\n1, 3.0, 1.5\n2, -1.25, 1.25\n\n3, 2e1, 1.0\n"


@pytest.fixture
def folder(tmp_path: Path) -> str:
    (tmp_path / "lot.csv").write_text(LOT)
    return str(tmp_path)


def test_values_in_the_unit_of_the_parameter(folder: str) -> None:
    spread = read_spread({"file": "lot.csv", "column": "offset"}, "V", folder)
    assert spread.values == (-0.00125, 0.003, 0.02)
    assert read_spread({"file": "lot.csv", "column": "gain"}, "V", folder).values == (1.0, 1.25, 1.5)
    drawn = [spread.at(0.0, uniform_deviate(1, k, 2, 0)) for k in range(3000)]
    counts = np.unique(drawn, return_counts=True)[1]
    assert abs(counts - 1000).max() < 4 * np.sqrt(3000 * 2 / 9)
    assert [spread.at(0.0, part) for part in (0.01, 0.34, 0.99)] == [-0.00125, 0.003, 0.02]


@pytest.mark.parametrize(
    ("table", "text", "key", "said"),
    [
        ({"column": "offest"}, LOT, "column", "did you mean offset?"),
        ({}, LOT, "column", "no such column"),
        ({"column": "gain"}, "gain,gain\n1,2\n", "column", "the file has 2 columns of this name"),
        ({"column": "offset"}, LOT.replace("3.0", "three"), "file", "line 2: not a number"),
        ({"column": "offset"}, LOT.replace("3.0", "nan"), "file", "line 2: not a number"),
        pytest.param(
            {"column": "offset"},
            LOT.replace("3.0", "5e-324"),
            "file",
            "line 2: not a number",
            marks=pytest.mark.defect("S1067", before="5e-324 mV in a column was 0 V", after="refused, as in a file"),
        ),
        ({"column": "offset"}, LOT.replace("3.0", "-1e-400"), "file", "line 2: not a number"),
        ({"column": "offset"}, LOT.replace("mV", "mA"), "column", "line 1: mA is"),
        ({"column": "gain"}, LOT + "4, 5\n", "file", "line 6"),
        ({"column": "gain"}, LOT.partition("\n")[0], "file", "0 rows"),
        ({"column": "gain"}, "", "column", "no such column"),
        ({"column": "gain"}, "\xff", "file", "cannot be read"),
        ({"column": "gain", "file": "lto.csv"}, LOT, "file", "did you mean lot.csv?"),
        ({"column": "gain", "file": "../lot.csv"}, LOT, "file", "outside the folder"),
        ({"column": "gain", "file": 5}, LOT, "file", "must be the name of a file"),
        ({"column": "gain", "relative": True}, LOT, "relative", "not relative"),
    ],
)
def test_mistakes(table: dict[str, object], text: str, key: str, said: str, folder: str) -> None:
    (Path(folder) / "lot.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(Refusal) as caught:
        read_spread({"file": "lot.csv"} | table, "V", folder)
    assert caught.value.key == key
    assert said in f"{caught.value} {caught.value.got} {caught.value.hint}"


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=False), min_size=1, max_size=50))
def test_numbers_are_rounded_once(numbers: list[float]) -> None:
    """Each as the quantity that it is with the unit of the head."""
    with tempfile.TemporaryDirectory() as folder:
        for head, unit in (("a [mV]", "mV"), ("a", "V")):
            (Path(folder) / "lot.csv").write_text("\n".join([head, *map(repr, numbers)]))
            expected = sorted(convert(f"{number!r} {unit}", "V") for number in numbers)
            assert list(read_column("lot.csv", "a", folder, "V")) == expected
