"""Own blocks of random formulas over constants at the edges of arithmetic: the same bits in every engine."""

import math
import random
from pathlib import Path

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.language.arithmetic import signed
from proofmass.runner.contract.contract import check_block

TABLE = ("0.0", "-0.0", "1.0", "-3.0", "5e-324", "1e308", "math.inf", "-math.inf", "math.nan", "-math.nan")
OPERATIONS = ("({} + {})", "({} - {})", "({} * {})", "min({}, {})", "max({}, {})", "math.copysign({}, {})")
OF_ONE = ("abs({})", "(-{})", "math.fabs({})")
FORMULAS = 16

HEAD = f'''"""Random formulas."""
import math

from proofmass import Block, Input

TABLE = ({", ".join(TABLE)})


class Hostile(Block):
    """Formulas of hostile numbers."""

    input = Input("1", "A number.")
'''
OUTPUT = '''

@Hostile.output("1")
def value_{number}(p, tick: int, input: float) -> float:
    """What shows of a formula on a wire: its sign, and whether it is below one."""
    x = {formula}
    return math.copysign(2.0, x) + (1.0 if x < 1.0 else 0.5)
'''


def _formula(dice: random.Random, depth: int) -> str:
    if depth == 0 or dice.random() < 0.1:
        choice = dice.random()
        if choice < 0.5:
            return dice.choice(TABLE)
        return "input" if choice < 0.7 else f"TABLE[(tick + {dice.randrange(len(TABLE))}) % {len(TABLE)}]"
    if dice.random() < 0.2:
        return dice.choice(OF_ONE).format(_formula(dice, depth - 1))
    return dice.choice(OPERATIONS).format(_formula(dice, depth - 1), _formula(dice, depth - 1))


@pytest.mark.exhaustive
@pytest.mark.defect(
    "S650",
    before="math.copysign of a NaN is -1 in plain Python and +1 in machine code",
    after="a NaN counts as positive in every engine",
)
@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(2, 12))])
def test_formulas_of_hostile_constants(seed: int, tmp_path: Path) -> None:
    dice = random.Random(seed)
    outputs = (OUTPUT.format(number=n, formula=_formula(dice, 3)) for n in range(FORMULAS))
    (tmp_path / "hostile.py").write_text(HEAD + "".join(outputs))
    report = check_block(load_own_blocks(tmp_path / "hostile.py")["Hostile"], sets=1)
    assert report.passed, [str(problem) for verdict in report.verdicts for problem in verdict.problems]


def test_a_sign_is_that_of_python_but_for_what_is_no_number() -> None:
    for size in (0.0, -2.0, math.inf):
        for sign in (0.0, -0.0, 3.0, -math.inf):
            assert str(signed(size, sign)) == str(math.copysign(size, sign))
        for sign in (math.nan, -math.nan, math.inf * 0.0):
            assert str(signed(size, sign)) == str(abs(size))
