"""Logarithmic ageing: value = nominal (1 + rate log10(1 + age / onset)), age = start_age + t."""

from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import logarithm, logarithm_of_one_plus
from proofmass.blocks.declaration.declare import Block, param

_PAST = "what has aged before would move too: take an ArrheniusAgeing, which adds up the pace of each moment"


class LogarithmicAgeing(Block):
    """Parameter that moves by so much a decade: references, resistors, resonators, magnets."""

    rate_per_decade: float = param(
        "1", "Relative deviation per factor of ten in age.", default=10.0e-6, not_driven=_PAST
    )
    onset: float = param("s", "Age at which the logarithm sets in.", default=86400.0, at_least=1.0e-3, not_driven=_PAST)
    start_age: float = param("s", "Age at the start.", default=0.0, at_least=0.0, at_most=1.0e12, not_driven=_PAST)
    nominal: float = param("{unit}", "Value when new.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")


class Constants(NamedTuple):
    rate: float
    onset: float
    start_age: float
    nominal: float


@LogarithmicAgeing.constants
def constants(p: LogarithmicAgeing, period: float) -> Constants:
    return Constants(p.rate_per_decade / logarithm(10.0), p.onset, p.start_age, p.nominal)


def deviation_at(c: Constants, time: float) -> float:
    """Relative deviation at a time."""
    return c.rate * logarithm_of_one_plus((c.start_age + time) / c.onset)


@LogarithmicAgeing.output("{unit}")
def value(c: Constants, time: float) -> float:
    """Nominal value with the deviation applied."""
    return c.nominal * (1.0 + deviation_at(c, time))


@LogarithmicAgeing.output("1")
def deviation(c: Constants, time: float) -> float:
    """The relative deviation."""
    return deviation_at(c, time)
