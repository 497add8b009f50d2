"""Several rates in one graph: ticks coincide exactly, slow to fast holds, fast to slow samples."""

from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import Ramp, UnitDelay
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate

ENGINES = ["python", "compiled"]


def two_rates(fast: str, slow: str) -> Graph:
    """A ramp at each rate, and each ramp sampled at the other rate."""
    return Graph(
        name="two rates",
        rate=fast,
        blocks={
            "fast": Ramp(slope=1.0),
            "slow": Ramp(slope=1.0),
            "fast_at_slow": UnitDelay(),
            "slow_at_fast": UnitDelay(),
        },
        rates={"slow": slow, "fast_at_slow": slow},
        wires=["fast.output -> fast_at_slow.input", "slow.output -> slow_at_fast.input"],
        probes=["fast.output", "slow.output", "fast_at_slow.output", "slow_at_fast.output"],
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_all_3201_slow_ticks_of_a_second_coincide(engine: str) -> None:
    result = simulate(two_rates("9.6 kHz", "3.2 kHz"), duration="1 s", engine=engine)  # type: ignore[arg-type]
    fast, slow = result["fast.output"], result["slow.output"]
    assert len(fast.values) == 9601
    assert len(slow.values) == 3201
    assert np.array_equal(slow.values, fast.values[::3])
    assert np.isin(slow.times, fast.times).sum() == 3201
    # sampled in the same tick, delayed by one slow tick
    assert np.array_equal(result["fast_at_slow.output"].values[1:], fast.values[:-3:3])
    # held: the fast delay sees each slow value three times
    assert np.array_equal(result["slow_at_fast.output"].values[1:], np.repeat(slow.values, 3)[:9600])


@pytest.mark.exhaustive("7/3 Hz")
@pytest.mark.parametrize(
    ("fast", "slow", "base", "divisors"),
    [
        ("9.6 kHz", "9600/1023 Hz", Fraction(9600), (1, 1023)),
        ("50 kHz", "9.6 kHz", Fraction(1_200_000), (24, 125)),
        ("1000/3 Hz", "100 Hz", Fraction(1000), (3, 10)),
        ("20 us", "7/3 Hz", Fraction(350_000), (7, 150_000)),
    ],
)
def test_base_rate_is_the_least_common_multiple(
    fast: str, slow: str, base: Fraction, divisors: tuple[int, int]
) -> None:
    scheduled = plan(two_rates(fast, slow)).schedule
    assert scheduled.base_rate == base
    assert (scheduled.divisors["fast"], scheduled.divisors["slow"]) == divisors


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("ratio", [2, 7, 1000])
def test_time_is_the_tick_times_the_period(engine: str, ratio: int) -> None:
    result = simulate(two_rates("9.6 kHz", f"{9600}/{ratio} Hz"), samples=4000, engine=engine)  # type: ignore[arg-type]
    assert np.array_equal(result["fast.output"].values, np.arange(4000) * (1 / 9600))
    assert np.array_equal(result["slow.output"].values, np.arange(0, 4000, ratio) * (1 / 9600))
