"""Functions of every block on dual numbers, against differences; whole ticks: `test_slopes_of_every_block`."""

import random
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of, unit_of
from proofmass.runner.contract.drawn import random_block
from proofmass.runner.derivatives.dual import dual, plain, slopes_of
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.dual_plan import dual_constants
from proofmass.runner.plan.constants import constants_of, start_of

PERIOD = 1e-4
QUANTISERS = {
    "AnalogToDigital",
    "DigitalToAnalog",
    "MashModulator",
    "PipelineAnalogToDigital",
    "Quantiser",
    "SigmaDeltaModulator",
    "SuccessiveApproximation",
    "UnipolarDigitalToAnalog",
    "WeightedDigitalToAnalog",
}
OF_VOLTAGES = {
    "AnalogToDigital",
    "MashModulator",
    "PipelineAnalogToDigital",
    "Quantiser",
    "SigmaDeltaModulator",
    "SuccessiveApproximation",
}  # of signals about 1, where others take codes
OF_WEIGHTS = {"PipelineAnalogToDigital", "SuccessiveApproximation", "WeightedDigitalToAnalog"}  # converters by these
SPREAD = 1e-4  # of gains of stages: larger ones skip more codes than are allowed for
KINDS = {
    name: kind
    for name, kind in all_blocks().items()
    if not name.startswith("Fixed") and not any(port.shape for port in kind.inputs.values())
}  # those in fixed point: test_dual_fixed


@pytest.mark.exhaustive(but=80)
@pytest.mark.exhaustive("RunningPercentile", "SpectrumMeter")
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_every_block_against_differences(kind: type[Block], tmp_path: Path) -> None:
    """Each function by each real state, input, constant and entry of a buffer, at random places."""
    dice = random.Random(kind.__name__)
    for _ in range(4):
        block = random_block(kind, dice, tmp_path)
        if "gain_spread" in kind.parameters:
            block = kind(**{n: getattr(block, n) for n in kind.parameters} | {"gain_spread": SPREAD})
        for role in (*kind.output_functions, "update", "derivative"):
            behaviour = kind.output_functions.get(role) or kind.functions.get(role)
            if behaviour is not None:
                _compare(block, behaviour.function, _arguments(block, behaviour.arguments, dice), kind.__name__)


@pytest.mark.exhaustive(but=80)
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_constants_of_every_block_against_differences(kind: type[Block], tmp_path: Path) -> None:
    dice = random.Random(kind.__name__)
    for _ in range(4):
        block = random_block(kind, dice, tmp_path)
        made = constants_of(block, block, PERIOD)
        for name, parameter in kind.parameters.items():
            if parameter.kind is not float:
                continue
            found = dual_constants(block, _with(block, name, dual(getattr(block, name), {name: 1.0})), PERIOD)
            found, made_flat = _flat(found), _flat(made)
            assert [plain(v) for v in found] == made_flat
            step = 1e-6 * (abs(getattr(block, name)) or 1.0)
            above, below = (_values_at(block, name, getattr(block, name) + s * step) for s in (1.0, -1.0))
            for got, high, low, value in zip(found, above, below, made_flat, strict=True):
                if _corner(high, value, low):
                    continue
                expected = (high - low) / (2.0 * step)
                assert slopes_of(got).get(name, 0.0) == pytest.approx(
                    expected, rel=1e-5, abs=1e-8 * abs(value) / step + 1e-300
                )


SIX_BITS: dict[str, dict[str, Any]] = {
    "AnalogToDigital": {"bits": 6},
    "SuccessiveApproximation": {"bits": 6},
    "PipelineAnalogToDigital": {"stages": 3, "last_bits": 3},
}


@pytest.mark.parametrize("name", SIX_BITS)
def test_converters_have_the_slope_of_their_steps_from_the_lowest_code_to_the_highest(name: str) -> None:
    block = KINDS[name](reference=1.0, **SIX_BITS[name])
    behaviour = KINDS[name].output_functions["number"]
    made = _arguments(block, behaviour.arguments, random.Random(1))
    place = 1 + behaviour.arguments.index("voltage")
    for steps in [code + part for code in range(-36, 36) for part in (-0.3, 0.3)]:
        voltage = dual(steps / 32.0, {"x": 1.0})
        found = for_duals(behaviour.function)(*made[:place], voltage, *made[place + 1 :])
        assert plain(found) == min(max(round(steps), -32), 31)
        assert slopes_of(found).get("x", 0.0) == (32.0 if -32.0 < steps < 31.0 else 0.0), steps


def _corner(up: float, middle: float, down: float) -> bool:
    """Whether the function bends within the step, so that a difference tells no derivative."""
    return bool(abs(up - 2.0 * middle + down) > 0.1 * abs(up - down) + 1e-6 * abs(middle))


def _values_at(block: Block, name: str, value: float) -> list[float]:
    return _flat(constants_of(block, _with(block, name, value), PERIOD))


def _flat(constants: Any) -> list[Any]:
    """Constants one by one, entries of lists too."""
    return [entry for value in constants for entry in (value if isinstance(value, tuple) else (value,))]


def _with(block: Block, name: str, value: Any) -> Any:
    class Changed:
        pass

    changed: Any = Changed()
    for parameter in type(block).parameters:
        setattr(changed, parameter, getattr(block, parameter))
    setattr(changed, name, value)
    return changed


def _arguments(block: Block, names: tuple[str, ...], dice: random.Random) -> list[Any]:
    """Constants, then whatever the function takes, as plain numbers; lists for buffers."""
    known: dict[str, Any] = {"time": 0.0123, "tick": 5, "normal": 0.7}
    for name, buffer in type(block).buffers.items():
        length = 7 if buffer.recorded else shape_of(block, buffer)[0]
        known[name] = sorted(_drawn(buffer.dtype, dice) for _ in range(length))
    if type(block).__name__ in OF_WEIGHTS:
        start_of(block, known, PERIOD)
    for name, port in type(block).inputs.items():
        known[name] = _drawn(port.dtype, dice) * (
            1e-7 if unit_of(block, port) == "m" else 1
        )  # plates that do not touch
    state = type(block).state_class()
    if state is not None:
        known["x"] = state(*(_drawn(k, dice) for k in state.__annotations__.values()))
    for port in type(block).outputs.values():
        if port.shape:
            known["out"] = [0] * shape_of(block, port)[0]
    return [constants_of(block, block, PERIOD), *(known[name] for name in names)]


def _drawn(kind: type, dice: random.Random) -> Any:
    return dice.uniform(0.1, 0.9) if kind is float else dice.randrange(2) if kind is int else dice.random() < 0.5


def _compare(block: Block, function: Any, arguments: list[Any], kind: str) -> None:
    base = _flat_results(function, arguments)
    for place in _places(arguments):
        value = _at(arguments, place)
        seeded = _moved(arguments, place, dual(value, {"x": 1.0}))
        found = _flat_results(for_duals(function), seeded)
        step = 1e-6 * (abs(value) or 1.0)
        if kind in OF_WEIGHTS:
            step = 0.02 * (abs(value) or 1.0)
        elif kind in OF_VOLTAGES:
            step = 0.3 * (abs(value) or 1.0)
        elif kind in QUANTISERS and place[0] > 0:
            step = 300.0
        high, low = (_flat_results(function, _moved(arguments, place, value + s * step)) for s in (1.0, -1.0))
        for got, up, down, middle in zip(found, high, low, base, strict=True):
            if _corner(up, middle, down):
                continue
            coarse = max(1.0, _half_a_step(block)) if kind in QUANTISERS else 0.0
            coarse = 3.0 if kind in OF_WEIGHTS else coarse  # wrong weights skip codes, too
            expected = (up - down) / (2.0 * step)
            allowed = 1e-5 * abs(expected) + 2e-9 * abs(middle) / step + coarse / step
            assert abs(slopes_of(got).get("x", 0.0) - expected) <= allowed, (kind, function.__name__, place)
            assert abs(plain(got) - middle) <= coarse


def _half_a_step(block: Any) -> float:
    """Of the levels of a modulator, which may have two of any size."""
    return float(block.reference / (block.levels - 1)) if hasattr(block, "feedback") else 0.0


def _flat_results(function: Any, arguments: list[Any]) -> list[Any]:
    """What a function returns, and what it leaves in its buffers."""
    own = [list(a) if isinstance(a, list) else a for a in arguments]
    result = function(*own)
    out = list(result) if isinstance(result, tuple) else [] if result is None else [result]
    return [*out, *(entry for a in own if isinstance(a, list) for entry in a)]


def _places(arguments: list[Any]) -> list[tuple[int, int]]:
    """Every real number among the arguments but time and noise; of a long buffer some fifty of its entries."""
    found = []
    for i, argument in enumerate(arguments):
        entries = argument if isinstance(argument, list | tuple) else [argument]
        apart = 1 + len(entries) // 50
        found += [(i, j) for j, entry in enumerate(entries) if isinstance(entry, float) and j % apart == 0]
    return found


def _at(arguments: list[Any], place: tuple[int, int]) -> float:
    argument = arguments[place[0]]
    return float(argument[place[1]] if isinstance(argument, list | tuple) else argument)


def _moved(arguments: list[Any], place: tuple[int, int], value: Any) -> list[Any]:
    i, j = place
    moved = list(arguments)
    if isinstance(moved[i], list):
        moved[i] = [value if k == j else entry for k, entry in enumerate(moved[i])]
    elif isinstance(moved[i], tuple):
        moved[i] = type(moved[i])(*(value if k == j else entry for k, entry in enumerate(moved[i])))
    else:
        moved[i] = value
    return moved
