"""The graph of a modulator: a state space whose entries are formulas of the named coefficients, and a quantiser."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.electronics.comparator import Comparator
from proofmass.blocks.filters.discrete_matrix_state_space import DiscreteMatrixStateSpace
from proofmass.blocks.filters.matrix_state_space import MatrixStateSpace
from proofmass.blocks.signals.quantiser import Quantiser
from proofmass.blocks.signals.sum import Sum
from proofmass.blocks.signals.vector_element import VectorElement
from proofmass.blocks.signals.vector_join import VectorJoin
from proofmass.blocks.sources.sine import Sine
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.rates import Rate
from proofmass.runner.design.modulators.simulation import enough_samples, tone_frequency
from proofmass.runner.design.modulators.structures import Coefficients, Structure, named

SAMPLES = 65_536
_FULL = (0.0, 1.0)


@dataclass(frozen=True)
class SumOfProducts:
    """A sum of products of names: from each product, sorted, to how often it counts."""

    terms: tuple[tuple[tuple[str, ...], int], ...]

    def __add__(self, other: Any) -> "SumOfProducts":
        """Return the sum."""
        total: dict[tuple[str, ...], int] = dict(self.terms)
        for names, count in _expression(other).terms:
            total[names] = total.get(names, 0) + count
        return SumOfProducts(tuple((names, count) for names, count in total.items() if count))

    def __mul__(self, other: Any) -> "SumOfProducts":
        """Return the product; of an array that with each entry."""
        if isinstance(other, np.ndarray):
            return NotImplemented
        product = SumOfProducts(())
        for names, count in self.terms:
            more = ((tuple(sorted((*names, *others))), count * times) for others, times in _expression(other).terms)
            product = product + SumOfProducts(tuple(more))
        return product

    def __sub__(self, other: Any) -> "SumOfProducts":
        """Return the difference."""
        return self + _expression(other) * -1

    def __rsub__(self, other: Any) -> "SumOfProducts":
        """Return the difference from a number."""
        return _expression(other) - self

    __radd__, __rmul__ = __add__, __mul__

    def __str__(self) -> str:
        """Return the text of a formula."""
        parts = [(count, " * ".join([*([str(abs(count))] if abs(count) > 1 or not names else []), *names]))
                 for names, count in sorted(self.terms)]  # fmt: skip
        text = "".join(f" {'-' if count < 0 else '+'} {part}" for count, part in parts) or " + 0"
        return text.removeprefix(" + ").replace(" - ", "-", 1) if text.startswith(" - ") else text.removeprefix(" + ")


def modulator_graph(structure: Structure, k: Coefficients, levels: int, band: tuple[float, float], rate: Rate) -> Graph:
    """Return the graph of a modulator with a sine of half scale; raises `ModelError` where a pulse has no blocks."""
    if structure.pulse not in (None, _FULL):
        hint = "design with a pulse of (0, 1), or wire a converter of this pulse yourself"
        got = " to ".join(f"{end:g}" for end in structure.pulse or ())
        raise Problem(message="has no graph", key="pulse", got=got, expected="0 to 1", hint=hint).error
    numbers: dict[str, float] = {}
    letters = {f"{letter}{i}": value for letter in "abcg" for i, value in enumerate(getattr(k, letter), 1)}

    def noted(name: str) -> SumOfProducts:
        numbers[name] = letters[name]
        return _name(name)

    entries = _entries(structure, named(k, noted))
    level = "quantiser.sign" if levels == 2 else "quantiser.output"
    loop_filter, wires, y = _loop_filter(structure, entries, level)
    blocks: dict[str, Any] = {"input": Sine(amplitude=0.5), **loop_filter}
    if k.b[structure.order]:
        blocks["forward"] = Sum()
        wires, y = [*wires, f"{y} -> forward.first", "input.output -> forward.second"], "forward.output"
    blocks["quantiser"] = Comparator() if levels == 2 else Quantiser(levels=levels)
    samples = enough_samples(SAMPLES, band)
    periods = round(tone_frequency(samples, band) * samples)
    return Graph(
        name=f"sigma-delta modulator of order {structure.order}, {structure.form}",
        rate="= clock",
        samples=samples,
        values={"clock": rate if isinstance(rate, str) else f"{float(rate)} Hz", **numbers},
        formulas={"input.frequency": f"= clock * {periods} / {samples}", **_formulas(entries)},
        blocks=blocks,
        wires=[*wires, f"{y} -> quantiser.input"],
        probes=[level, "input.output"],
    )


def _entries(structure: Structure, k: Coefficients) -> dict[str, Any]:
    """Return the matrices of the state space as expressions; per second if continuous."""
    rows, last = structure.matrices(k)
    n = structure.order
    per_second = _name("clock") if structure.pulse else _expression(1)
    return {"transition": per_second * rows[:, :n], "entry": per_second * rows[:, n:], "readout": last[:n]}


def _loop_filter(structure: Structure, entries: dict[str, Any], level: str) -> tuple[dict[str, Any], list[str], str]:
    """Return the blocks of the loop filter, the wires into it, and its output."""
    numbers: dict[str, Any] = {name: tuple(map(_number, part.reshape(-1))) for name, part in entries.items()}
    if structure.pulse:
        blocks = {"loop_filter": MatrixStateSpace(input_size=2, output_size=1, **numbers)}
        return blocks, ["input.output -> loop_filter.first", f"{level} -> loop_filter.second"], "loop_filter.one"
    space = DiscreteMatrixStateSpace(order=structure.order, input_size=2, output_size=1, direct=(0.0, 0.0), **numbers)
    wires = ["input.output -> inputs.first", f"{level} -> inputs.second", "inputs.output -> loop_filter.input"]
    wires += ["loop_filter.strictly_proper_part -> last.vector"]
    return {"inputs": VectorJoin(size=2), "loop_filter": space, "last": VectorElement(size=1)}, wires, "last.output"


def _formulas(entries: dict[str, Any]) -> dict[str, str]:
    """Return the formula of each entry that has names in it."""
    return {
        f"loop_filter.{name}[{place}]": f"= {value}"
        for name, part in entries.items()
        for place, value in enumerate(map(_expression, part.reshape(-1)))
        if any(names for names, _ in value.terms)
    }


def _name(name: str) -> SumOfProducts:
    return SumOfProducts((((name,), 1),))


def _number(value: Any) -> float:
    """Return the number of an entry without names; of others their formula has it."""
    return float(sum(count for names, count in _expression(value).terms if not names))


def _expression(value: Any) -> SumOfProducts:
    """Return a whole number as an expression."""
    return value if isinstance(value, SumOfProducts) else SumOfProducts((((), int(value)),) if value else ())
