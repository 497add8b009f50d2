"""Blocks from linear systems of python-control and SciPy, of which neither is imported: a system is
read by its names.

x' = A x + B u, y = C x + D u        or x[n+1] = ..., or coefficients of s or z, highest power first
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.blocks.filters.discrete_matrix_state_space import DiscreteMatrixStateSpace
from proofmass.blocks.filters.discrete_state_space import DiscreteStateSpace
from proofmass.blocks.filters.discrete_transfer_function import DiscreteTransferFunction
from proofmass.blocks.filters.matrix_state_space import MatrixStateSpace
from proofmass.blocks.filters.state_space import StateSpace
from proofmass.blocks.filters.transfer_function import TransferFunction
from proofmass.blocks.signals.gain import Gain
from proofmass.graphs.model.rates import Rate, read_rate, simplest, write_rate

_SINGLE = 4  # order of a continuous block with a port for its direct part
_SAME = 1e-9  # relative difference of two periods that count as one


@named_arguments
def from_control(system: Any, *, rate: Rate | None = None, input_unit: str = "1", output_unit: str = "1") -> Block:
    """Return the block of a `system` of python-control, a `StateSpace` or a `TransferFunction`.

    A system of continuous time becomes a `StateSpace`, `TransferFunction` or `MatrixStateSpace`,
    one of discrete time a `DiscreteStateSpace`, `DiscreteTransferFunction` or
    `DiscreteMatrixStateSpace`, one without states a `Gain`. Its coefficients are taken as they are,
    in `input_unit` and `output_unit`. A discrete one is only right at the rate that it was made
    for: name the `rate` of the block in its graph, which must be 1/dt of the system.

    Raises `ModelError` for a system that no block holds, and for another rate.

    >>> import control
    >>> from proofmass import from_control
    >>> from_control(control.tf([1.0], [1e-3, 1.0]), input_unit="V", output_unit="V")
    TransferFunction(denominator=(0.001, 1.0), input_unit='V', output_unit='V')
    >>> from_control(control.ss([[0.5]], [[0.5]], [[1.0]], [[0.0]], 1e-3), rate="1 kHz").transition
    (0.5,)
    """
    dt = getattr(system, "dt", None)
    if hasattr(system, "num"):
        numerators, denominators = _of_pairs(system.num), _of_pairs(system.den)
        if len(numerators) != 1:
            raise _refusal("is a transfer function of several inputs or outputs", "control.ss(system) has matrices")
        return _fraction(numerators[0], denominators[0], dt if dt else None, rate, (input_unit, output_unit))
    return _matrices(system, dt if dt else None, rate, (input_unit, output_unit))


@named_arguments
def from_scipy(system: Any, *, rate: Rate | None = None, input_unit: str = "1", output_unit: str = "1") -> Block:
    """Return the block of a `system` of SciPy, `scipy.signal.lti` or `dlti`, as `from_control` does.

    `rate`, `input_unit` and `output_unit` are those of the block.

    Raises `ModelError` for a system that no block holds, and for another rate.

    >>> from scipy import signal
    >>> from proofmass import from_scipy
    >>> from_scipy(signal.lti([1.0], [1.0, 2.0, 1.0]))
    TransferFunction(denominator=(1.0, 2.0, 1.0))
    """
    if isinstance(system, Sequence) or hasattr(system, "shape"):
        hint = "scipy.signal.lti(b, a) is of continuous time, scipy.signal.dlti(b, a, dt=0.001) of discrete time"
        raise _refusal("is only numbers: neither their time nor what they are is known", hint)
    if hasattr(system, "zeros") and hasattr(system, "gain"):
        system = system.to_tf()
    if hasattr(system, "num"):
        return _fraction(system.num, system.den, system.dt, rate, (input_unit, output_unit))
    return _matrices(system, getattr(system, "dt", None), rate, (input_unit, output_unit))


def _of_pairs(coefficients: Any) -> list[Any]:
    """Return the coefficients of each pair of an input and an output."""
    return [pair for row in coefficients for pair in row]


def _fraction(numerator: Any, denominator: Any, dt: Any, rate: Rate | None, units: tuple[str, str]) -> Block:
    above, below = np.trim_zeros(np.atleast_1d(numerator), "f"), np.trim_zeros(np.atleast_1d(denominator), "f")
    names = dict(zip(("input_unit", "output_unit"), units, strict=True))
    _check_rate(dt, rate)
    if not len(above) or (len(above) == len(below) == 1):
        return Gain(gain=float(above[0] / below[0]) if len(above) else 0.0, **names)
    if len(above) > len(below):
        raise _refusal("has more zeros than poles", "no block differentiates; add poles beyond the band that matters")
    if dt is not None:
        return DiscreteTransferFunction(numerator=_row(above), denominator=_row(below), **names)
    if len(below) > _SINGLE + 1:
        hint = "write it as factors, blocks in series that are integrated together exactly; or control.ss(system)"
        message = f"is of order {len(below) - 1}; a TransferFunction is of order {_SINGLE} at most"
        raise _refusal(message, hint)
    return TransferFunction(numerator=_row(above), denominator=_row(below), **names)


def _matrices(system: Any, dt: Any, rate: Rate | None, units: tuple[str, str]) -> Block:
    try:
        a, b, c, d = (np.atleast_2d(np.asarray(getattr(system, name), dtype=float)) for name in "ABCD")
    except AttributeError:
        hint = "take a StateSpace or a TransferFunction; linearise one that is not linear first"
        raise _refusal("is not a linear system", hint, type(system).__name__) from None
    names: dict[str, Any] = dict(zip(("input_unit", "output_unit"), units, strict=True))
    (outputs, inputs), order = d.shape, a.shape[1]
    parts: dict[str, Any] = {"transition": _row(a), "entry": _row(b), "readout": _row(c)}
    single = inputs == outputs == 1
    _check_rate(dt, rate)
    if single and not order:
        return Gain(gain=float(d[0, 0]), **names)
    if dt is not None and single:
        return DiscreteStateSpace(**parts, direct=float(d[0, 0]), **names)
    if dt is not None:
        if set(units) != {"1"}:
            raise _refusal("has several inputs or outputs, for which a block has no units", "leave the units out")
        sizes: dict[str, Any] = {"order": order, "input_size": inputs, "output_size": outputs}
        return DiscreteMatrixStateSpace(**sizes, **parts, direct=_row(d))
    if single and order <= _SINGLE:
        return StateSpace(**parts, direct=float(d[0, 0]), **names)
    if d.any():
        message = f"has a direct part, which a block of {'order over 4' if single else 'several inputs'} has not"
        raise _refusal(message, "wire a Gain of D beside the block, and set D of the system to zero")
    return MatrixStateSpace(input_size=inputs, output_size=outputs, **parts, **names)


def _row(numbers: Any) -> tuple[float, ...]:
    return tuple(np.asarray(numbers, dtype=float).ravel().tolist())


def _check_rate(dt: Any, rate: Rate | None) -> None:
    """Hold the rate of a block against the time step of a system, None in continuous time and True where unsaid."""
    if dt is None:
        if rate is not None:
            raise _refusal("is of continuous time: it has no rate", "leave the rate out")
        return
    if dt is True:
        return
    wanted = f'from_control(system, rate="{write_rate(simplest(1.0 / dt))}")'
    if rate is None:
        hint = f"name the rate at which the block will run: {wanted}"
        raise _refusal("is of discrete time, and right at one rate only", hint, f"dt = {dt:g} s")
    given = read_rate(rate)
    if abs(float(given) * float(dt) - 1.0) > _SAME:
        hint = "sample the system anew for this rate, or run the block at the other one"
        raise _refusal(f"was made for a time step of {dt:g} s, not for {write_rate(given)}", hint, str(rate))


def _refusal(message: str, hint: str, got: str = "") -> ModelError:
    return Problem(message=message, key="system", got=got, hint=hint).error
