"""Parameters of many runs at once: the numbers of `Study.drawn`, to the bit, as arrays.

Every deviate is plain arithmetic on whole numbers and floats, which NumPy does with the same bits; where a function
looks at its argument, it is called for one after the other.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from proofmass.blocks.counter_random import central_quantile, is_central, normal_quantile, uniform_deviate
from proofmass.graphs.designs import stream_of
from proofmass.graphs.graph import split
from proofmass.graphs.study import Study

Array = np.ndarray[Any, np.dtype[Any]]
_uniform_deviate: Any = uniform_deviate  # of arrays too
_central_quantile: Any = central_quantile
_is_central: Any = is_central


def drawn_together(study: Study, numbers: Sequence[int]) -> dict[str, Array]:
    """Parameters of some runs by `block.parameter` of the flat graph: an array with a row for each epoch."""
    runs = np.array(numbers, dtype=np.int64)
    points = [study.point(number) for number in numbers] if study.sweep else []
    drawn = {name: _rows(study, np.array([point[name] for point in points])) for name in study.sweep}
    deviates = dict(zip(study.spread, _deviates(study, runs // study.points), strict=True))
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
            peers = np.array([study.peer(number) // study.points for number in numbers], dtype=np.int64)
            law: Any = study.drift[name]
            aged = law.aged(value, study.epochs, study.seed, peers, stream_of("drift", name), normal_deviates)
            drawn[name] = np.array(aged)
    return drawn


def normal_deviates(seed: int, runs: Array, stream: int, sample: int) -> Array:
    """`normal_deviate` of many runs."""
    return normal_quantiles(_uniform_deviate(seed, runs, stream, sample))


def normal_quantiles(probabilities: Array) -> Array:
    """`normal_quantile` of many probabilities."""
    q = probabilities - 0.5
    central = _is_central(q)
    quantiles: Array = _central_quantile(np.where(central, q, 0.0))
    quantiles[~central] = [normal_quantile(each) for each in probabilities[~central].tolist()]
    return quantiles


def _rows(study: Study, values: Array) -> Array:
    return np.tile(values, (len(study.epochs), 1))


def _deviates(study: Study, sensors: Array) -> Array:
    """Uniform deviates: a row for each spread parameter."""
    design = study.designed
    if design.kind == "random":
        streams = np.array([[stream_of("spread", name)] for name in study.spread], dtype=np.int64).reshape(-1, 1)
        return np.asarray(_uniform_deviate(study.seed, sensors, streams, 0))
    return np.array([[design.deviate(sensor, name) for sensor in sensors.tolist()] for name in study.spread])


def _spread(spread: Any, nominal: Array, uniforms: Array) -> Array:
    if spread.shape == "uniform":
        return np.asarray(spread.at(nominal, uniforms))
    if spread.shape == "normal":
        normals = normal_quantiles(spread.inside(uniforms))
        return _of_normals(spread, nominal, np.maximum(-spread.truncated, np.minimum(normals, spread.truncated)))
    return np.array([spread.at(*each) for each in zip(nominal.tolist(), uniforms.tolist(), strict=True)])


def _of_normals(spread: Any, nominal: Array, normals: Array) -> Array:
    if spread.shape == "normal":
        return np.asarray(spread.of_normal(nominal, normals))
    return np.array([spread.of_normal(*each) for each in zip(nominal.tolist(), normals.tolist(), strict=True)])
