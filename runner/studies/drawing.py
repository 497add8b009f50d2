"""Parameters of many runs at once: the numbers of `Study.drawn`, to the bit, as arrays.

The functions of one deviate are compiled and applied to arrays; all else is plain arithmetic on whole numbers and
floats, which NumPy does with the same bits.
"""

from typing import Any

import numpy as np

from proofmass.blocks.counter_random import normal_deviate, normal_quantile, uniform_deviate
from proofmass.blocks.elementary import exponential
from proofmass.graphs.designs import half_of_bits, permuted, stream_of
from proofmass.graphs.distributions import Spread
from proofmass.graphs.graph import split
from proofmass.graphs.study import Study
from proofmass.runner.engine.elementwise import Elementwise
from proofmass.runner.engine.result import Array

_KEY = {"seed": int, "run": int, "stream": int, "sample": int}
uniform_deviates = Elementwise(uniform_deviate, _KEY, float)
normal_deviates = Elementwise(normal_deviate, _KEY, float)
normal_quantiles = Elementwise(normal_quantile, {"probability": float}, float)
exponentials = Elementwise(exponential, {"x": float}, float)
permutations = Elementwise(permuted, {"number": int, "size": int, "half": int, "seed": int, "stream": int}, int)


def drawn_together(study: Study, runs: Array) -> dict[str, Array]:
    """Parameters of some runs by `block.parameter` of the flat graph: an array with a row for each epoch."""
    sensors = runs // study.points
    drawn = {name: _rows(study, value) for name, value in _points(study, runs).items()}
    deviates = {name: _deviates(study, sensors, name) for name in study.spread}
    correlation: Any = study.correlation
    normals = correlation.applied({n: normal_quantiles(deviates[n]) for n in correlation.names})
    for name in dict.fromkeys([*study.spread, *study.drift]):
        block, parameter = split(name)
        value = drawn[name][0] if name in drawn else np.full(len(runs), getattr(study.flat.blocks[block], parameter))
        if name in normals:
            value = _of_normals(study.spread[name], value, normals[name])
        elif name in study.spread:
            value = _spread(study.spread[name], value, deviates[name])
        drawn[name] = _rows(study, value)
        if name in study.drift:
            peers: Any = study.peer(runs) // study.points  # type: ignore[arg-type]
            law: Any = study.drift[name]
            aged = law.aged(value, study.epochs, study.seed, peers, stream_of("drift", name), normal_deviates)
            drawn[name] = np.array(aged)
    return drawn


def _rows(study: Study, values: Array) -> Array:
    return np.tile(values, (len(study.epochs), 1))


def _points(study: Study, runs: Array) -> dict[str, Array]:
    """What the parameters of the sweep are."""
    every = [study.point(number) for number in range(study.points)] if study.sweep else []
    return {name: np.array([point[name] for point in every])[runs % study.points] for name in study.sweep}


def _deviates(study: Study, sensors: Array, name: str) -> Array:
    """Uniform deviates of one parameter."""
    design, stream = study.designed, stream_of("spread", name)
    if design.kind == "random":
        return uniform_deviates(study.seed, sensors, stream, 0)
    if design.kind == "latin_hypercube":
        strata = permutations(sensors, study.runs, half_of_bits(study.runs), study.seed, stream)
        return np.asarray(design.within(strata, uniform_deviates(study.seed, sensors, stream, 0), np.minimum))
    return np.array([design.deviate(sensor, name) for sensor in sensors.tolist()])


def _spread(spread: Spread, nominal: Any, uniforms: Any) -> Array:
    """`Spread.at` of many sensors."""
    if spread.shape == "normal" or spread.shape == "lognormal":
        normals = normal_quantiles(spread.inside(uniforms))
        return _of_normals(spread, nominal, np.maximum(-spread.truncated, np.minimum(normals, spread.truncated)))
    if spread.shape == "uniform":
        return np.asarray(spread.at(nominal, uniforms))
    return np.array([spread.at(*each) for each in zip(nominal.tolist(), uniforms.tolist(), strict=True)])


def _of_normals(spread: Any, nominal: Array, normals: Array) -> Array:
    return np.asarray(spread.of_normal(nominal, normals, exponentials))
