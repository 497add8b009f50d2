"""Parameters of many runs at once: the numbers of `Study.drawn`, to the bit, as arrays.

Functions of one deviate are compiled and applied to arrays; the rest is plain arithmetic on
integers and floats, for which NumPy gives the same bits.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from proofmass.blocks.arithmetic.counter_random import normal_deviate, normal_quantile, uniform_deviate
from proofmass.blocks.arithmetic.elementary import exponential
from proofmass.graphs.formulas.operations import KNOWN, OPERATIONS
from proofmass.graphs.studies.designs import half_of_bits, permuted, stream_of
from proofmass.graphs.studies.distributions import NORMAL, Spread
from proofmass.graphs.studies.study import Study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.targets.elementwise import Elementwise

_PLAIN: Mapping[str, Any] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "negative": np.negative,
    KNOWN: lambda value, of: np.where(value - value == of - of, value, np.nan),
}  # fmt: skip
_KEY = {"seed": int, "run": int, "stream": int, "sample": int}
uniform_deviates = Elementwise(uniform_deviate, _KEY, float)
normal_deviates = Elementwise(normal_deviate, _KEY, float)
normal_quantiles = Elementwise(normal_quantile, {"probability": float}, float)
exponentials = Elementwise(exponential, {"x": float}, float)
permutations = Elementwise(permuted, {"number": int, "size": int, "half": int, "seed": int, "stream": int}, int)


def drawn_together(study: Study, runs: AnyArray, *, apart: bool = False) -> dict[str, AnyArray]:
    """Return parameters and values of runs by their names in the flat graph: arrays with a row for each epoch.

    With `apart` each of them is what it would be if nothing it follows from were spread or drifted.
    """
    sensors = runs // study.points
    swept = {name: _rows(study, value) for name, value in _points(study, runs).items()}
    drawn = dict(swept)
    deviates = _deviates(study, sensors)
    normals = _normals(study, deviates)
    for name in study.moved:
        base = drawn[name] if name in study.sweep else _base(study, name, swept if apart else drawn, len(runs))
        if (base == base[0]).all():
            drawn[name] = _aged(study, name, base[0], runs, deviates, normals)
        else:  # what it follows from drifts
            aged = (_aged(study, name, row, runs, deviates, normals)[epoch] for epoch, row in enumerate(base))
            drawn[name] = np.array(list(aged))
    return drawn


def on_arrays(operation: str, arguments: list[Any]) -> Any:
    """Return the result of an operation of a formula on arrays, with the bits of the operation on each entry."""
    with np.errstate(all="ignore"):
        if operation in _PLAIN:
            return _PLAIN[operation](*arguments)
    return _elementwise(operation)(*arguments)


@cache
def _elementwise(operation: str) -> Elementwise:
    known = OPERATIONS[operation]
    return Elementwise(known.function, dict.fromkeys(("first", "second")[: known.arity], float), float)


def _base(study: Study, name: str, drawn: Mapping[str, AnyArray], runs: int) -> AnyArray:
    """Return what a parameter or value is before it is spread, a row for each epoch."""
    followed = study.dependence.followed(drawn, on_arrays).get(name, study.nominal(name))
    return np.broadcast_to(followed, (len(study.epochs), runs))


def _aged(
    study: Study,
    name: str,
    base: AnyArray,
    runs: AnyArray,
    deviates: Mapping[str, AnyArray],
    normals: Mapping[str, AnyArray],
) -> AnyArray:
    """Return a parameter spread and aged from its base, a row for each epoch."""
    value = base
    if name in normals:
        spread: Any = study.spread[name]
        value = np.asarray(spread.of_normal(value, normals[name], exponentials))
    elif name in study.spread:
        value = _spread(study.spread[name], value, deviates[name])
    if name not in study.drift:
        return _rows(study, value)
    peers: Any = study.peer(runs) // study.points  # type: ignore[arg-type]
    law: Any = study.drift[name]
    return np.array(law.aged(value, study.epochs, study.seed, peers, stream_of("drift", name), normal_deviates))


def _rows(study: Study, values: AnyArray) -> AnyArray:
    return np.tile(values, (len(study.epochs), 1))


def _points(study: Study, runs: AnyArray) -> dict[str, AnyArray]:
    """Return the parameters of the sweep."""
    every = [study.point(number) for number in range(study.points)] if study.sweep else []
    return {name: np.array([point[name] for point in every])[runs % study.points] for name in study.sweep}


def _deviates(study: Study, sensors: AnyArray) -> dict[str, AnyArray]:
    """Return uniform deviates of the spread parameters."""
    design, names = study.designed, list(study.spread)
    if design.kind not in ("random", "latin_hypercube"):
        return {name: np.array([design.deviate(sensor, name) for sensor in sensors.tolist()]) for name in names}
    streams = np.array([stream_of("spread", name) for name in names], dtype=np.int64)[:, None]
    rows = uniform_deviates(study.seed, sensors, streams, 0)
    if design.kind == "latin_hypercube":
        strata = permutations(sensors, study.runs, half_of_bits(study.runs), study.seed, streams)
        rows = np.asarray(design.within(strata, rows, np.minimum))
    return dict(zip(names, rows, strict=True))


def _normals(study: Study, deviates: Mapping[str, AnyArray]) -> dict[str, AnyArray]:
    """Return standard normal deviates, correlated and truncated, of parameters that need them."""
    spreads: dict[str, Any] = {name: spread for name, spread in study.spread.items() if spread.shape in NORMAL}
    if not spreads:
        return {}
    rows = normal_quantiles(np.array([spread.inside(deviates[name]) for name, spread in spreads.items()]))
    normals = dict(zip(spreads, rows, strict=True))
    bounded = {n: np.maximum(-s.truncated, np.minimum(normals[n], s.truncated)) for n, s in spreads.items()}
    correlated: Any = study.correlation
    bounded |= correlated.applied(normals)
    return bounded


def _spread(spread: Spread, nominal: Any, uniforms: Any) -> AnyArray:
    """Return `Spread.at` for many sensors, for shapes that do not follow from normal deviates."""
    if spread.shape == "uniform":
        return np.asarray(spread.at(nominal, uniforms))
    return np.array([spread.at(*each) for each in zip(nominal.tolist(), uniforms.tolist(), strict=True)])
