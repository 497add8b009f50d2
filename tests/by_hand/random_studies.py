"""Random studies of constants: what a run was given is what it measures."""

import random
from typing import Any

from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.studies.build import Study

_UNITS = ("V", "kg", "1")


def random_study(seed: int, runs: int = 3) -> tuple[Study, dict[str, str]]:
    """Return a study, and for each parameter and value that varies the measure that shows it.

    Some constants follow formulas, some of which follow from values that follow from others. All may be spread, swept
    or drift, in any order; normal ones may be correlated, and a calibration may leave a parameter of its own.
    """
    dice = random.Random(seed)
    values = {f"v{n}": dice.choice([-1.0, 1.0]) * dice.uniform(0.5, 3.0) for n in range(4)}
    texts = {name: repr(number) for name, number in values.items()}
    texts |= {f"w{n}": f'"= {n + 2} * v{n} - v{n + 1} * {dice.choice(["v0", "0.5"])}"' for n in range(2)}
    blocks, shown = list[str](), dict[str, str]()
    for name in texts:
        blocks.append(f'shown_{name} = {{ kind = "Constant", value = "= {name}" }}')
        shown[name] = f"shown_{name}"
    for n in range(7):
        followed = dice.choice([*texts, None])
        unit = "1" if followed else dice.choice(_UNITS)
        value = f'"= {followed} + {n}"' if followed else repr(dice.choice([-1.0, 1.0]) * dice.uniform(0.5, 3.0))
        blocks.append(f'c{n} = {{ kind = "Constant", value = {value}, unit = "{unit}" }}')
        shown[f"c{n}.value"] = f"c{n}"
    blocks.append('register = { kind = "Constant", value = 1.0 }')
    dice.shuffle(blocks)
    measures = [f'at_{block} = {{ signal = "{block}.output", statistic = "last" }}' for block in shown.values()]
    measures.append('new = "= 2 * at_shown_v0"')
    lines = ['name = "constants"', 'rate = "1 kHz"', "samples = 1", "[values]"]
    lines += [f"{name} = {text}" for name, text in dice.sample(list(texts.items()), len(texts))]
    graph = read_graph_text("\n".join([*lines, "[measures]", *measures, "[blocks]", *blocks]) + "\n")
    return Study(graph, runs=runs, seed=seed, **_tables(dice, list(shown))), {n: f"at_{b}" for n, b in shown.items()}


def _tables(dice: random.Random, names: list[str]) -> dict[str, Any]:
    spread = {name: _spread(dice) for name in dice.sample(names, dice.randint(2, 7))}
    tables: dict[str, Any] = {"spread": spread}
    normal = [n for n, s in spread.items() if {"normal", "lognormal"} & s.keys() and "truncated" not in s]
    if len(normal) > 1 and dice.random() < 0.7:
        tables["correlation"] = {normal[0]: {normal[1]: dice.choice([-1.0, -0.6, 0.5, 1.0])}}
    if dice.random() < 0.6:
        tables["sweep"] = {name: [1.0, -2.0, 0.7][: dice.randint(1, 3)] for name in dice.sample(names, 1)}
    if dice.random() < 0.7:
        tables["epochs"] = {"ages": ["0 h", "1 year", "3 year"]}
        laws: list[dict[str, Any]] = [
            {"ramp": "5 %/year", "ramp_spread": "1 %/year", "relative": True},
            {"random_walk": "3 %/sqrt(year)", "relative": True},
            {"logarithmic": "2 %", "relative": True},
        ]
        tables["drift"] = {name: dice.choice(laws) for name in dice.sample(names, dice.randint(1, 3))}
        if dice.random() < 0.5:
            every = ["never", "1 year"][: dice.randint(1, 2)]
            tables["recalibration"] = {"every": every, "carried": {"register.value": "new"}}
    return tables


def _spread(dice: random.Random) -> dict[str, Any]:
    return dice.choice(
        [
            {"normal": "3 %", "relative": True},
            {"normal": "3 %", "relative": True, "truncated": 2},
            {"normal": 0.1},
            {"lognormal": 0.1},
            {"uniform": "5 %", "relative": True},
            {"triangular": 0.2},
            {"values": [1.0, 2.0, 4.0], "weights": [1, 2, 1]},
        ]
    )
