"""Steady Kalman filter: x = m + K (z - C m), m[n+1] = A x[n] + B u[n] (Anderson and Moore, Optimal Filtering, 1979)."""

import math
from collections.abc import Iterator

from proofmass.blocks.arithmetic.riccati import steady_gain
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class KalmanFilter(Block):
    """Best linear estimate of the states of a system from one noisy measurement; order 1 to 16."""

    transition: tuple[float, ...] = param("1", "A, row after row.", default=(1.0, 1.0, 0.0, 1.0))
    entry: tuple[float, ...] = param("1/({control_unit})", "B, one per state.", default=(0.0, 0.0))
    readout: tuple[float, ...] = param("{unit}", "C, one per state.", default=(1.0, 0.0))
    process_noise: tuple[float, ...] = param("1", "Covariance of what moves them, Q.", default=(0.0, 0.0, 0.0, 0.01))
    measurement_noise: float = param("({unit})^2", "Variance of the measurement, R.", default=1.0, above=0.0)
    unit: str = param("", "Unit of the measurement.", default="1")
    control_unit: str = param("", "Unit of the control.", default="1")

    measurement = Input("{unit}", "Measurement z.")
    control = Input("{control_unit}", "Known input u that drives the states.", default=0.0)

    matrix = Buffer("A.", float, ("transition",))
    column = Buffer("B.", float, ("entry",))
    row = Buffer("C.", float, ("readout",))
    gain = Buffer("K.", float, ("entry",))
    prediction = Buffer("m, zero in tick 0.", float, ("entry",))
    following = Buffer("m of the next tick, while it is computed.", float, ("entry",))


@KalmanFilter.requires
def requires(p: KalmanFilter) -> Iterator[tuple[str, str]]:
    order = len(p.entry)
    if order > 16:
        yield "entry", "at most 16 numbers"
    sizes = {"transition": order * order, "readout": order, "process_noise": order * order}
    wrong = {name: size for name, size in sizes.items() if len(getattr(p, name)) != size}
    yield from ((name, f"{size} numbers, as entry has {order}") for name, size in wrong.items())
    steady = [] if wrong else steady_gain(p.transition, p.readout, p.process_noise, p.measurement_noise)
    if not all(map(math.isfinite, steady)):
        yield "readout", "a measurement of all that grows by itself"


@KalmanFilter.start
def start(p: KalmanFilter, matrix: list[float], column: list[float], row: list[float], gain: list[float]) -> None:
    matrix[:], column[:], row[:] = p.transition, p.entry, p.readout
    gain[:] = steady_gain(p.transition, p.readout, p.process_noise, p.measurement_noise)


@KalmanFilter.output("{unit}")
def innovation(p: KalmanFilter, row: list[float], prediction: list[float], measurement: float) -> float:
    """The measurement less its prediction."""
    for i in range(len(row)):
        measurement -= row[i] * prediction[i]
    return measurement


@KalmanFilter.output("1", shape=("entry",), dtype=float)
def states(
    p: KalmanFilter, row: list[float], gain: list[float], prediction: list[float], measurement: float, out: list[float]
) -> None:
    """The estimated states, with this measurement."""
    new = innovation(p, row, prediction, measurement)
    for i in range(len(gain)):
        out[i] = prediction[i] + gain[i] * new


@KalmanFilter.output("{unit}")
def estimate(
    p: KalmanFilter, row: list[float], gain: list[float], prediction: list[float], measurement: float
) -> float:
    """Measurement without noise, C x."""
    new = innovation(p, row, prediction, measurement)
    total = measurement - new  # C m
    for i in range(len(gain)):
        total += row[i] * gain[i] * new
    return total


@KalmanFilter.update
def update(
    p: KalmanFilter,
    matrix: list[float],
    column: list[float],
    row: list[float],
    gain: list[float],
    prediction: list[float],
    following: list[float],
    measurement: float,
    control: float,
) -> None:
    new, order = innovation(p, row, prediction, measurement), len(gain)
    for i in range(order):
        following[i] = column[i] * control
        for j in range(order):
            following[i] += matrix[i * order + j] * (prediction[j] + gain[j] * new)
    for i in range(order):
        prediction[i] = following[i]
