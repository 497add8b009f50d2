"""Reduced-order model of a structure: M x'' + C x' + K x = B F, y = R x, by its lowest modes.

M, C and K come from a finite-element program, B has a column for each force, R a row for each point
that is read. The step is exact for forces held over a tick. Modes that are left out add nothing,
also not at rest (Craig and Kurdila, Fundamentals of Structural Dynamics, 2006, chapters 10 and 17).
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.matrices import product_with_part, stepped
from proofmass.blocks.arithmetic.modes import is_positive_definite, lowest_modes, modal_step, product, rows, size_of
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class ModalReducedOrderModel(Block):
    """Structure by its matrices of mass, damping and stiffness, from forces at its ports to motion at others."""

    mass: tuple[float, ...] = param("kg", "M, n by n, row after row; n is at most 64.", default=(1e-8, 0.0, 0.0, 1e-8))
    damping: tuple[float, ...] = param("kg/s", "C, n by n, row after row.", default=(1e-6, 0.0, 0.0, 1e-6))
    stiffness: tuple[float, ...] = param("N/m", "K, n by n, row after row.", default=(2.0, -1.0, -1.0, 2.0))
    entry: tuple[float, ...] = param("1", "B, n by input_size, row after row.", default=(1.0, 0.0))
    readout: tuple[float, ...] = param("1", "R, output_size by n, row after row.", default=(0.0, 1.0))
    input_size: int = param("1", "Number of forces.", default=1, at_least=1, at_most=16)
    output_size: int = param("1", "Number of points that are read.", default=1, at_least=1, at_most=16)
    modes: int = param("1", "Modes that count, the lowest first.", default=2, at_least=1, at_most=32)

    force = Input("N", "Forces, held over a tick.", shape=("input_size",))

    matrix = Buffer("From states to states, over a tick.", float, (lambda p: 4 * p.modes * p.modes,))
    into = Buffer("From forces to states, over a tick.", float, (lambda p: 2 * p.modes * p.input_size,))
    places = Buffer("From modal displacements times rates.", float, (lambda p: p.output_size * p.modes,))
    speeds = Buffer("From modal velocities.", float, (lambda p: p.output_size * p.modes,))
    states = Buffer("Modal displacements times rates, then velocities.", float, (lambda p: 2 * p.modes,))
    following = Buffer("States of the next tick, while they are computed.", float, (lambda p: 2 * p.modes,))


@ModalReducedOrderModel.requires
def requires(p: ModalReducedOrderModel) -> Iterator[tuple[str, str]]:
    n = size_of(p.mass)
    if n == 0:
        yield "mass", "n by n numbers, n at most 64"
        return
    sizes = {"damping": n * n, "stiffness": n * n, "entry": n * p.input_size, "readout": n * p.output_size}
    wrong = [name for name, size in sizes.items() if len(getattr(p, name)) != size]
    yield from ((name, f"{sizes[name]} numbers, as mass is {n} by {n}") for name in wrong)
    if p.modes > n:
        yield "modes", f"at most {n}, as mass is {n} by {n}"
    for name in ("mass", "stiffness"):
        if name not in wrong and not is_positive_definite(rows(getattr(p, name), n)):
            yield name, "a symmetric, positive definite matrix: that of a structure that is held everywhere"


@ModalReducedOrderModel.start
def start(
    p: ModalReducedOrderModel,
    matrix: list[float],
    into: list[float],
    places: list[float],
    speeds: list[float],
    period: float,
) -> None:
    n = size_of(p.mass)
    modes = lowest_modes(rows(p.mass, n), rows(p.damping, n), rows(p.stiffness, n), p.modes)
    seen = product(rows(p.readout, n), modes.shapes)
    step = modal_step(modes, rows(p.entry, p.input_size), period)
    states = 2 * p.modes
    matrix[:], into[:] = [v for row in step for v in row[:states]], [v for row in step for v in row[states:]]
    speeds[:] = [v for row in seen for v in row]
    places[:] = [v / rate for row in seen for v, rate in zip(row, modes.rates, strict=True)]


@ModalReducedOrderModel.output("m", shape=("output_size",), dtype=float)
def displacement(p: ModalReducedOrderModel, places: list[float], states: list[float], out: list[float]) -> None:
    """Displacements of the points that are read."""
    product_with_part(places, states, 0, p.modes, out)


@ModalReducedOrderModel.output("m/s", shape=("output_size",), dtype=float)
def velocity(p: ModalReducedOrderModel, speeds: list[float], states: list[float], out: list[float]) -> None:
    """Velocities of the points that are read."""
    product_with_part(speeds, states, p.modes, p.modes, out)


@ModalReducedOrderModel.update
def update(
    p: ModalReducedOrderModel,
    matrix: list[float],
    into: list[float],
    states: list[float],
    following: list[float],
    force: list[float],
) -> None:
    stepped(matrix, states, into, force, following)
