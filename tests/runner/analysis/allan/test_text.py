"""The table of Allan deviations: each row has all deviations of its averaging time."""

import functools

import numpy as np
import pytest

from proofmass import Allan, allan
from proofmass.runner.analysis.allan.freedom import AllanStatistic
from tests.by_hand.amounts import chosen


@functools.cache
def deviations(unit: str) -> Allan:
    return allan(np.random.default_rng(5).standard_normal(300), rate=10.0, unit=unit)


def test_a_row_has_the_deviations_of_its_averaging_time() -> None:
    found = deviations("V")
    lines = str(found).splitlines()
    rows = [line.split() for line in lines[1 + next(i for i, line in enumerate(lines) if "tau [s]" in line) :]]
    every = [(row[0], row[1], row[6]) for row in rows if len(row) > 6]
    assert [float(tau) for tau, _, _ in every[:4]] == pytest.approx([0.1, 0.2, 0.4, 0.8])
    for number, statistic in ((1, AllanStatistic.ALLAN), (2, AllanStatistic.HADAMARD)):
        curve = found.curves[statistic]
        at = {f"{tau:.6g}": f"{value:.6g}" for tau, value in zip(curve.taus, curve.deviation, strict=True)}
        assert [row[number] for row in every] == [at[row[0]] for row in every]


@pytest.mark.defect("C878", before="a column in degC or dB ended in a UnitError", after="deviations in that unit")
@pytest.mark.parametrize("unit", chosen(["degC", "dB"], ["furlong"]))
def test_units_that_no_table_has_stay_as_they_are(unit: str) -> None:
    assert str(deviations(unit)).replace(unit, "V") == str(deviations("V"))
