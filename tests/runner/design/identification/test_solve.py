"""Least squares for unknowns, over models that are written here as arrays: against NumPy's and formulas of books."""

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.identification.recordings import RecordedStretch
from proofmass.runner.design.identification.solve import UnknownsSolver
from proofmass.runner.design.identification.unknowns import Unknown
from proofmass.runner.design.quantities.stopping import InterruptedSearch
from proofmass.runner.host.arrays import AnyArray

TIMES = np.arange(200) / 200.0
Formula = Callable[[Mapping[str, float], AnyArray], AnyArray]


class Written:
    """A model whose outputs are formulas of the unknowns and of time, and the unknowns of each of its runs."""

    def __init__(self, outputs: Mapping[str, AnyArray], *formulas: Formula) -> None:
        self.recording = RecordedStretch("written", TIMES, {}, outputs)
        self.signals = sorted(outputs)
        self.formulas = formulas
        self.rows: list[AnyArray] = []  # of the last run
        self.asked: list[dict[str, float]] = []
        self.delays: list[dict[str, float]] = []

    @property
    def runs(self) -> int:
        return len(self.asked)

    def outputs(self, values: Mapping[str, float], delays: Mapping[str, float]) -> list[AnyArray] | None:
        self.asked.append(dict(values))
        self.delays.append(dict(delays))
        self.rows = [formula(values, TIMES) for formula in self.formulas]
        return self.rows


def unknown(name: str, start: float, **more: float) -> Unknown:
    return Unknown(name, name, "1", start, **more)


def solver(models: Sequence[Any], unknowns: Sequence[Unknown], loss: str = "linear", skip: float = 0.0) -> Any:
    return UnknownsSolver(models, unknowns, loss, skip, None, None)


def line(p: Mapping[str, float], t: AnyArray) -> AnyArray:
    return np.asarray(p["a"] + p["b"] * t)


NOISE = 0.05 * np.random.default_rng(3).standard_normal(len(TIMES))
LINE = {"y": 2.0 - 3.0 * TIMES + NOISE}
AB = [unknown("a", 1.0), unknown("b", -1.0)]


def test_a_line_is_that_of_numpy_with_its_noise() -> None:
    solution = solver([Written(LINE, line)], AB).solved(np.array([1.0, -1.0]))
    table = np.stack([np.ones_like(TIMES), TIMES], axis=1)
    best, (squares,), _, _ = np.linalg.lstsq(table, LINE["y"])
    assert solution.values == pytest.approx(best, rel=1e-7)
    noise = math.sqrt(squares / (len(TIMES) - 2))  # two unknowns less
    assert solution.noise == {"y": pytest.approx(noise, rel=1e-9)}
    assert solution.residuals == pytest.approx((table @ best - LINE["y"]) / noise, abs=1e-5)
    assert solution.jacobian == pytest.approx(table / noise, rel=1e-6)
    assert solution.converged


def test_every_output_has_its_own_noise_and_recordings_count_together() -> None:
    """y = a + noise and z = a + five times as much: the mean by weights 1/variance, of two recordings each."""
    rough = 0.25 * np.random.default_rng(4).standard_normal((2, len(TIMES)))
    fine = 0.05 * np.random.default_rng(5).standard_normal((2, len(TIMES)))

    def level(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.full_like(t, p["a"])

    models = [Written({"y": 1.0 + fine[n], "z": 1.0 + rough[n]}, level, level) for n in range(2)]
    several = solver(models, [unknown("a", 2.0)])
    solution = several.solved(np.array([2.0]))
    weights = {signal: solution.noise[signal] ** -2 for signal in "yz"}
    mean = 1.0 + (weights["y"] * fine.mean() + weights["z"] * rough.mean()) / (weights["y"] + weights["z"])
    assert solution.values == pytest.approx([mean], rel=1e-6)
    free = 2 * len(TIMES) - 0.5  # each output carries half of the unknown
    for signal, parts in (("y", fine), ("z", rough)):
        squares = float(np.sum((1.0 + parts - mean) ** 2))
        assert solution.noise[signal] == pytest.approx(math.sqrt(squares / free), rel=1e-3)
    assert several.compared("z") == pytest.approx((1.0 + rough).ravel())
    assert [sorted(outputs) for outputs in several.modelled(np.array([0.5]))] == [["y", "z"]] * 2
    assert several.modelled(np.array([0.5]))[1]["z"] == pytest.approx(np.full(len(TIMES), 0.5))
    assert several.runs == sum(model.runs for model in models) > 2


def test_rows_that_miss_or_come_before_the_skip_do_not_count() -> None:
    values = {"y": np.where(TIMES < 0.25, 1e6, LINE["y"])}
    values["y"][100:120] = np.nan
    some = solver([Written(values, line)], AB, skip=0.25)
    kept = (TIMES >= 0.25) & np.isfinite(values["y"])
    table = np.stack([np.ones_like(TIMES), TIMES], axis=1)[kept]
    solution = some.solved(np.array([1.0, -1.0]))
    assert solution.values == pytest.approx(np.linalg.lstsq(table, LINE["y"][kept])[0], rel=1e-7)
    (modelled,) = some.modelled(solution.values)
    assert np.array_equal(np.isfinite(modelled["y"]), kept)


def test_what_is_known_beforehand_weighs_as_one_more_reading() -> None:
    known = [unknown("a", 1.0, expected=2.1, uncertainty=0.002), unknown("b", -1.0)]
    solution = solver([Written(LINE, line)], known).solved(np.array([1.0, -1.0]))
    noise = solution.noise["y"]
    table = np.vstack([np.stack([np.ones_like(TIMES), TIMES], axis=1) / noise, [1.0 / 0.002, 0.0]])
    best = np.linalg.lstsq(table, np.append(LINE["y"] / noise, 2.1 / 0.002))[0]
    assert solution.values == pytest.approx(best, rel=1e-6)
    assert solution.jacobian[-1] == pytest.approx([500.0, 0.0], rel=1e-6), "the prior below the recordings"
    assert len(solution.residuals) == len(TIMES), "residuals are of recordings alone"


def test_a_bound_holds_and_the_rest_is_the_best_beside_it() -> None:
    bounded = [unknown("a", 1.0, at_most=1.5), unknown("b", -1.0)]
    solution = solver([Written(LINE, line)], bounded).solved(np.array([1.0, -1.0]))
    slope = float(TIMES @ (LINE["y"] - 1.5) / (TIMES @ TIMES))
    assert solution.values[0] == pytest.approx(1.5, rel=1e-6)
    assert solution.values[0] <= 1.5
    assert solution.values[1] == pytest.approx(slope, rel=1e-5)


def test_outliers_do_not_count_in_the_noise() -> None:
    """Without them a normal deviate: its median size is 0.6745 of its deviation."""
    values = {"y": LINE["y"] + np.where(np.arange(len(TIMES)) % 20 == 3, 50.0, 0.0)}
    solution = solver([Written(values, line)], AB, "outliers").solved(np.array([1.0, -1.0]))
    assert solution.values == pytest.approx([2.0, -3.0], abs=0.03)
    left = solution.values[0] + solution.values[1] * TIMES - values["y"]
    assert solution.noise["y"] == pytest.approx(1.4826 * np.median(np.abs(left)) * math.sqrt(200.0 / 198.0), rel=1e-6)


def test_an_unknown_that_changes_nothing_stays_where_it_begins() -> None:
    model, more = Written(LINE, line), [*AB, unknown("c", 4.0)]
    solution = solver([model], more).solved(np.array([1.0, -1.0, 4.0]))
    assert solution.values == pytest.approx([*np.polyfit(TIMES, LINE["y"], 1)[::-1], 4.0], rel=1e-6)
    assert solution.jacobian[:, 2] == pytest.approx(np.zeros(len(TIMES)))
    assert [at["c"] for at in model.asked] == pytest.approx([4.0] * model.runs, rel=0.011), "steps of 1 %"


def test_offsets_are_added_and_delays_go_to_the_outputs_that_have_them() -> None:
    def rising(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(p["b"] * t)

    unknowns = [unknown("b", 1.0), unknown("offset of y", 0.5), unknown("delay of y", 1e-3), unknown("delay of q", 0.0)]
    model = Written(LINE, rising)
    fit = solver([model], unknowns)
    ((signal, difference),) = fit.raw(np.array([-3.0, 2.0, 5e-3, 7.0]))
    assert signal == "y"
    assert difference == pytest.approx(-NOISE)
    assert (model.asked[-1], model.delays[-1]) == ({"b": -3.0}, {"y": 5e-3}), "q is no output of this model"


def test_steps_of_derivatives_move_an_output_by_a_part_of_its_size() -> None:
    """3e-3 of its deviation, over the root mean square of what 1 of an unknown's size does."""
    model = Written(LINE, line)
    fit = solver([model], AB)
    moved = 3e-3 * float(np.std(LINE["y"])) / np.array([1.0, math.sqrt(np.mean(TIMES**2))])
    model.asked.clear()
    fit.jacobian(np.array([7.0, -1.0]))
    assert [at["a"] - 7.0 for at in model.asked] == pytest.approx([moved[0], -moved[0], 0.0, 0.0])
    assert [at["b"] + 1.0 for at in model.asked] == pytest.approx([0.0, 0.0, moved[1], -moved[1]])


@pytest.mark.parametrize(("code", "kind"), [(0.25, float), (1, np.int64)])
def test_steps_of_derivatives_move_a_converter_by_ten_codes(code: float, kind: Any) -> None:
    """The model's, in volts or in codes, which a step of 3e-3 of its size would not leave."""

    def converted(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(np.round(1e5 * line(p, t) / code) * code).astype(kind)

    model = Written(LINE, converted)
    start = np.array([0.2, -2e-4])
    fit = solver([model], [unknown("a", start[0]), unknown("b", start[1])])
    model.asked.clear()
    fit.jacobian(start)
    assert model.asked[0]["a"] - start[0] == pytest.approx(10.0 * code / 1e5, rel=0.1)


def test_a_step_stays_within_the_bounds_and_the_derivative_is_of_the_step() -> None:
    model = Written(LINE, line)
    fit = solver([model], [unknown("a", 1.0, at_most=1.0), unknown("b", -1.0)])
    model.asked.clear()
    table = fit.jacobian(np.array([1.0, -1.0]))
    assert max(at["a"] for at in model.asked) == 1.0
    assert table[:, 0] == pytest.approx(np.full(len(TIMES), 1.0 / fit.noise["y"]), rel=1e-9)


def test_a_run_that_fails_is_far_from_everything() -> None:
    class Failing(Written):
        def outputs(self, values: Mapping[str, float], delays: Mapping[str, float]) -> list[AnyArray] | None:
            return None if values["a"] > 1.9 else super().outputs(values, delays)

    fit = solver([Failing(LINE, line)], AB)
    assert fit.residuals(np.array([1.95, 0.0])) == pytest.approx(np.full(len(TIMES), 1e6))


def test_a_converter_in_the_model_does_not_stop_the_last_steps() -> None:
    """Codes of 2e-3 with as much noise: the sum of squares is rough, its least place is that of a line through both."""
    noisy = {"y": 2.0 - 3.0 * TIMES + 2e-3 * np.random.default_rng(8).standard_normal(len(TIMES))}

    def codes(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(np.round(line(p, t) / 2e-3) * 2e-3)

    solution = solver([Written(noisy, codes)], AB).solved(np.array([1.0, -1.0]))
    table = np.stack([np.ones_like(TIMES), TIMES], axis=1)
    errors = solution.noise["y"] * np.sqrt(np.diag(np.linalg.inv(table.T @ table)))
    assert np.all(np.abs(solution.values - np.linalg.lstsq(table, noisy["y"])[0]) < errors)


def test_a_search_that_is_stopped_leaves_its_best_values() -> None:
    stop, told = threading.Event(), list[tuple[int, int]]()
    model = Written(LINE, line)
    stopped = UnknownsSolver([model], AB, "linear", 0.0, lambda done, most: told.append((done, most)), stop)  # type: ignore[list-item]
    before = stopped.residuals(np.array([1.9, -2.9]))
    stop.set()
    with pytest.raises(InterruptedSearch):
        stopped.solved(np.array([1.0, -1.0]))
    stopped.interrupt()
    state = stopped.as_it_is(np.array([1.9, -2.9]))
    assert state.noise["y"] == pytest.approx(math.sqrt(np.sum((1.9 - 2.9 * TIMES - LINE["y"]) ** 2) / (len(TIMES) - 2)))
    assert state.residuals * state.noise["y"] == pytest.approx(before * np.std(LINE["y"]))
    assert (state.cost, state.converged) == (math.inf, False)
    assert all(done < most for done, most in told), "there is always more to do"


def test_an_output_without_a_value_that_is_compared_has_a_spread_of_one() -> None:
    none = {"y": np.full(len(TIMES), np.nan), "z": LINE["y"]}
    assert solver([Written(none, line, line)], AB).spread("y") == 1.0
    still = {"y": np.full(len(TIMES), -4.0), "z": np.zeros(len(TIMES))}
    assert [solver([Written(still, line, line)], AB).spread(name) for name in "yz"] == [4.0, 1.0]


@pytest.mark.defect("S798", before="a = 1.12 for 2 and converged: derivatives saw few codes or none", after="found")
@pytest.mark.parametrize("code", [0.01, 0.03, 0.1, 0.3, 0.5])
@pytest.mark.parametrize("spread", [0.0, 0.05, 0.3])
def test_a_line_through_a_coarse_converter(code: float, spread: float) -> None:
    """A recording of 2 - 3 t in codes of up to a sixth of its size: no worse than the line that made it, from afar."""

    def coded(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(code * np.round(line(p, t) / code))

    noise = spread * np.random.default_rng(8).standard_normal(len(TIMES))
    recorded = code * np.round((2.0 - 3.0 * TIMES + noise) / code)
    found = solver([Written({"y": recorded}, coded)], AB).solved(np.array([1.0, -1.0]))
    left, made = (
        float(np.sum((coded({"a": a, "b": b}, TIMES) - recorded) ** 2)) for a, b in (found.values, (2.0, -3.0))
    )
    assert left <= 1.1 * made + len(TIMES) * (0.5 * code) ** 2
    assert found.values == pytest.approx([2.0, -3.0], abs=0.2 if spread == 0.3 else 0.05)


@pytest.mark.parametrize(
    ("start", "truth", "noise"), [(1.0, 100.0, 50.0), (1.0, 1e3, 500.0), (-1.0, 1e3, 500.0), (1e-3, 1e3, 100.0)]
)
@pytest.mark.defect("S920", before="100.2 +- 9.8 was 44.8 +- 13, converged: held to the start", after="as NumPy")
def test_a_factor_that_begins_far_away_is_that_of_numpy(start: float, truth: float, noise: float) -> None:
    wave = np.sin(2.0 * np.pi * 7.0 * TIMES)
    recorded = truth * wave + noise * np.random.default_rng(1).standard_normal(len(TIMES))

    def scaled(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(p["a"] * wave)

    solution = solver([Written({"y": recorded}, scaled)], [unknown("a", start)]).solved(np.array([start]))
    (best,), (squares,), _, _ = np.linalg.lstsq(wave[:, np.newaxis], recorded)
    assert solution.values == pytest.approx([best], rel=1e-6)
    assert solution.noise["y"] == pytest.approx(math.sqrt(squares / (len(TIMES) - 1)), rel=1e-6)
    assert solution.converged


@pytest.mark.parametrize("truth", [5e3, -5e3, 1e12])
@pytest.mark.defect("S920", before="an offset of 5000 was 42: it begins at 0, as one of size 1", after="the mean")
def test_an_offset_has_the_size_of_what_is_recorded(truth: float) -> None:
    recorded = truth * (1.0 + 0.1 * np.random.default_rng(2).standard_normal(len(TIMES)))

    def still(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.zeros_like(t)

    solution = solver([Written({"y": recorded}, still)], [unknown("offset of y", 0.0)]).solved(np.array([0.0]))
    assert solution.values == pytest.approx([np.mean(recorded)], rel=1e-6)
    assert solution.converged


@pytest.mark.parametrize("cubic", [1e12, -1e12])
@pytest.mark.defect("S920", before="a cubic stiffness of 1e12 N/m^3 was 2e-9 and converged", after="found from 0")
def test_a_large_coefficient_is_found_from_zero(cubic: float) -> None:
    place = 1e-5 * np.sin(2.0 * np.pi * 7.0 * TIMES)
    force = 100.0 * place + cubic * place**3 + 1e-6 * np.random.default_rng(6).standard_normal(len(TIMES))

    def spring(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(p["linear"] * place + p["cubic"] * place**3)

    unknowns = [unknown("linear", 100.0), unknown("cubic", 0.0)]
    solution = solver([Written({"y": force}, spring)], unknowns).solved(np.array([100.0, 0.0]))
    best = np.linalg.lstsq(np.stack([place, 1e10 * place**3], axis=1), force)[0]
    assert solution.values == pytest.approx([best[0], best[1] * 1e10], rel=1e-5)


@pytest.mark.parametrize(("bounds", "truth"), [({"at_most": 0.0}, -4e6), ({"at_least": 0.0}, 4e6)])
@pytest.mark.defect("S920", before="a slope of 4e6 from 0 was 9 after 60 steps", after="found within one bound")
def test_what_begins_at_a_bound_of_zero_goes_inside(bounds: dict[str, float], truth: float) -> None:
    recorded = truth * TIMES

    def rising(p: Mapping[str, float], t: AnyArray) -> AnyArray:
        return np.asarray(p["b"] * t)

    solution = solver([Written({"y": recorded}, rising)], [unknown("b", 0.0, **bounds)]).solved(np.zeros(1))
    assert solution.values == pytest.approx([truth], rel=1e-6)
