"""A study as text, whole, of values that were written by hand."""

from dataclasses import replace

import numpy as np
import pytest

from proofmass.runner.studies.shown.text import study_text
from tests.by_hand.study_results import AGED, LIMITED, SWEPT, study_result

# Student's t of three values is 4.302653, of two 12.7062; exact ends of 3 of 3, 2 of 3 and 0 of 3 are in percent
# 100 * 0.025^(1/3) = 29.24, and 9.43 to 99.16, and 100 * (1 - 0.025^(1/3)) = 70.76.
TWO_POINTS = """\
a converter that ages: 6 runs at 3 epochs, python engine, 1.5 s

filter.corner_frequency = 100 Hz:

measure  unit      age      mean       std     p1  p50    p99
bias     V         0 h  1.08(36)  0.144338      1    1  1.245
bias     V      1 year  2.17(72)  0.288675      2    2   2.49
bias     V     3 years  2.92(36)  0.144338  2.755    3      3
noise              0 h         5         0      5    5      5
noise           1 year         6         0      6    6      6
noise          3 years         7         0      7    7      7
in brackets half of the 95 % confidence interval, in units of the last digits; none of too few runs

yield, bias: 100.00 %, with 95 % confidence 29.24 to 100.00 %
yield, noise: 100.00 %, with 95 % confidence 29.24 to 100.00 %
yield, all limits: 100.00 %, with 95 % confidence 29.24 to 100.00 %

filter.corner_frequency = 200 Hz:

measure  unit      age      mean       std    p1  p50    p99
bias     V         0 h   1.8(26)   1.04083  1.01  1.5   2.97
bias     V      1 year   2.5(37)       1.5  1.03  2.5   3.97
bias     V     3 years  3.92(95)  0.381881  3.51    4  4.245
noise              0 h         5         0     5    5      5
noise           1 year         6         0     6    6      6
noise          3 years         7         0     7    7      7
in brackets half of the 95 % confidence interval, in units of the last digits; none of too few runs

yield, bias: 0.00 %, with 95 % confidence 0.00 to 70.76 %
yield, noise: 100.00 %, with 95 % confidence 29.24 to 100.00 %
yield, all limits: 0.00 %, with 95 % confidence 0.00 to 70.76 %

against filter.corner_frequency = 100 Hz, sensor by sensor, at 3 years:

point                             measure  unit  difference
filter.corner_frequency = 200 Hz  bias     V        1.0(12)
filter.corner_frequency = 200 Hz  noise                   0"""

FAILED = """\
a converter that ages: 3 runs, python engine, 1.5 s

measure  unit  age   mean      std    p1  p50   p99
bias           0 h  2(19)  2.12132  0.53    2  3.47
noise          0 h  7(25)  2.82843  5.04    7  8.96
in brackets half of the 95 % confidence interval, in units of the last digits; none of too few runs

yield, bias: 33.33 %, with 95 % confidence 0.84 to 90.57 %
yield, noise: 33.33 %, with 95 % confidence 0.84 to 90.57 %
yield, all limits: 33.33 %, with 95 % confidence 0.84 to 90.57 %
stopped after 2 of 3 runs: that was enough
the worker tcp://a:1 ended early; others did its runs
2 of 3 failed; run 1 at epoch 0: a wire broke"""

MANY_POINTS = """\
a converter that ages: 13 runs, python engine, 1.5 s

measure  unit  age  mean      std    p1  p50    p99
bias           0 h     6  3.89444  0.12    6  11.88
in brackets half of the 95 % confidence interval, in units of the last digits; none of too few runs


all 13 points of the sweep together; study.nc has them one by one"""


def test_each_point_has_a_table_and_yields_and_is_compared_with_the_first_at_the_last_age() -> None:
    bias = [[1, 2, 3], [1.5, 2.5, 3.5], [1.25, 2.5, 2.75], [1, 1, 4.25], [1, 2, 3], [3, 4, 4]]
    result = study_result(SWEPT + AGED + LIMITED, {"bias": bias, "noise": [[5, 6, 7]] * 6}, {"bias": "V"})
    assert study_text(result) == TWO_POINTS


def test_one_age_an_early_end_a_lost_worker_and_the_first_fault() -> None:
    result = study_result(LIMITED, {"bias": [[0.5], [np.nan], [3.5]], "noise": [[5], [np.nan], [9]]})
    faults = {(1, 0): "a wire broke", (2, 0): "another"}
    assert study_text(replace(result, planned_runs=2, lost_workers=("tcp://a:1",), faults=faults)) == FAILED


def test_many_points_are_told_together() -> None:
    swept = f'sweep = {{ "filter.corner_frequency" = {[*range(1, 14)]} }}\n'
    assert study_text(study_result(swept, {"bias": [[k] for k in range(13)]})) == MANY_POINTS


@pytest.mark.defect("S973", before="the mean of 1 of 3 runs, as if of all", after="how many runs have a value")
def test_measures_that_some_runs_have_no_value_of_are_named() -> None:
    lines = study_text(study_result(LIMITED, {"bias": [[0.5], [np.nan], [np.inf]], "noise": [[5.0], [6.0], [7.0]]}))
    assert "bias: 1 of 3 runs have a value; the others do not count" in lines.splitlines()
    assert "noise: " not in lines.replace("yield, noise: ", "")
