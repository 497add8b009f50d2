"""Claims under slow change: what is proved never grows, however parameters move within their rates.

Truth is in matrices of a period written down by hand. A path q(1), ..., q(M), q(1) that keeps its rate may be gone
around again and again: where the product of its matrices has a spectral radius above one, the loop grows.
"""

import itertools
import math
import random
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.design.proof import search
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.contraction import Norm
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.toleranced_loops import RATE, Loop, random_loop
from tests.runner.design.proof.test_any_change import swing
from tests.runner.design.proof.test_prove import GRAPH, status
from tests.runner.verification.test_certificates import forged

STIFFNESS = "first.stiffness"


def changing(loop: Loop, rate: Any, **more: Any) -> Proofs:
    within = {name: f"{100.0 * width} %" for name, width in loop.tolerances.items()}
    given = {"gain_margin": "0.1 dB", "phase_margin": "0.1 deg", "workers": 1} | more
    return prove(loop.graph(), tolerances=within, slow_change=rate, **given)


def radius_of_path(matrices: list[Any]) -> float:
    """The spectral radius of a product of matrices, a part for each."""
    product, size = np.eye(len(matrices[0])), 0.0
    for matrix in matrices:
        product = matrix @ product
        size += math.log(np.linalg.norm(product) or 1e-300)
        product = product / (np.linalg.norm(product) or 1.0)
    largest = float(max(abs(np.linalg.eigvals(product)))) or 1e-300
    return math.exp((size + math.log(largest)) / len(matrices))


def waves(width: float, step: float, longest: int) -> Iterator[list[float]]:
    """Paths about zero that keep to a width and a step: up and down as fast as may be, with and without rests."""
    for half in sorted({1, 2, 3, *map(int, np.geomspace(4, longest, 14))}):
        size = min(width, 0.5 * half * step)
        ramp = [min(size, -size + step * place) for place in range(half)]
        yield [*ramp, *(-value for value in ramp)]
        rest = [size] * (half // 2)
        yield [*ramp, *rest, *(-value for value in ramp), *(-value for value in rest)]


def greedy(matrix: Callable[[float], Any], width: float, step: float, count: int) -> float:
    """The growth in a period of a parameter that always goes where the state is longest two steps later.

    Lengths are those of the slowest mode in the middle, so that turning it adds none.
    """
    poles, vectors = np.linalg.eig(matrix(0.0))
    back = np.linalg.inv(vectors)[np.argsort(-abs(poles))[:2]]
    grid = [step * place for place in range(-int(width / step), int(width / step) + 1)]
    known = {place: matrix(place) for place in grid}
    at, x, sizes = len(grid) // 2, np.real(vectors.sum(axis=1)), []
    for _ in range(count):
        ways = itertools.product((-1, 0, 1), repeat=2)
        places = [(at + a, at + a + b) for a, b in ways if 0 <= at + a < len(grid) and 0 <= at + a + b < len(grid)]
        ends = [np.linalg.norm(back @ known[grid[j]] @ known[grid[i]] @ x) for i, j in places]
        at = places[int(np.argmax(ends))][0]
        x = known[grid[at]] @ x
        sizes.append(math.log(np.linalg.norm(back @ x)))
        x = x / np.linalg.norm(back @ x)
    return sum(sizes[count // 2 :]) / (count - count // 2)


def of_stiffness(loop: Loop) -> Callable[[float], Any]:
    return lambda away: np.real(loop.matrix(loop.values | {STIFFNESS: loop.values[STIFFNESS] + away}))


@pytest.fixture(scope="module")
def slow() -> Proofs:
    """The stiffness of a swing within 10 %, which has no norm for all of it, at 30 % in a second."""
    return changing(swing(0.1), "30 %/s")


def test_a_swing_is_proved_where_it_changes_slowly(slow: Proofs) -> None:
    """Mathieu's: a damping ratio of 0.02 bears no change of 10 % at twice the frequency, 10,000 % in a second."""
    assert status(slow) == ["proved"] * 3
    assert len(slow.proofs[0].searched.leaves) > 3
    lines = check_certificate(certificate(slow))
    step = 0.3 * 1e4 / RATE
    assert lines[0].startswith("main, stable under slow change: ")
    assert lines[0].endswith(f"first.stiffness from 9000 to 11000 by at most {step:g} a period")
    assert "changes by at most 3 kN·m/rad in a second" in proofs_text(slow)
    assert "stable under slow change" in proofs_text(slow)


@pytest.mark.exhaustive
def test_paths_of_a_swing_grow_where_they_are_fast_and_nothing_is_proved_there() -> None:
    loop = swing(0.1)
    matrix = of_stiffness(loop)
    step, fast = 0.3 * 1e4 / RATE, 100.0 * 1e4 / RATE
    assert max(radius_of_path(list(map(matrix, path))) for path in waves(1e3, fast, 64)) > 1.0005
    assert greedy(matrix, 1e3, fast, 2000) > 5e-4
    assert max(radius_of_path(list(map(matrix, path))) for path in waves(1e3, step, 400)) < 1.0
    assert greedy(matrix, 1e3, step, 4000) < -1e-4
    found = changing(loop, "10000 %/s", seconds=3.0)
    assert found.proofs[0].status == "open"
    assert "with parameters that stay it is" in found.proofs[0].searched.why


SAMPLE = (9,)


@pytest.mark.parametrize("seed", chosen(SAMPLE, [seed for seed in range(60) if seed not in SAMPLE]))
def test_no_path_contradicts_a_proof(seed: int) -> None:
    loop, draw = random_loop(seed), random.Random(seed)
    if loop.radius(loop.values) > 0.9999:
        loop.values["gain.gain"] *= 0.5
    period = loop.ticks / RATE
    nominal = loop.radius(loop.values)
    part, wanted = draw.choice((0.05, 0.5, 5.0, 50.0)), draw.choice((0.3, 0.7))
    rate = -wanted * math.log(nominal) / period if nominal < 1.0 else 1.0
    stable, *_, decays = changing(loop, f"{100.0 * part} %/s", decay_rate=f"{rate!r} 1/s", seconds=9.0).proofs
    steps = {name: part * abs(loop.values[name]) * period for name in loop.tolerances}
    widths = {name: width * abs(loop.values[name]) for name, width in loop.tolerances.items()}
    largest = 0.0
    for _ in range(12):
        of_all = {name: list(waves(widths[name], steps[name], 60)) for name in loop.tolerances}
        number, signs = draw.randrange(len(next(iter(of_all.values())))), (-1.0, 1.0)
        moves = {name: draw.choice(signs) * np.array(paths[number]) for name, paths in of_all.items()}
        moves = {name: np.roll(path, draw.randrange(len(path))) for name, path in moves.items()}
        count = len(next(iter(moves.values())))
        values = [
            loop.values | {name: loop.values[name] + float(path[k]) for name, path in moves.items()}
            for k in range(count)
        ]
        for here, there in itertools.pairwise([*values, values[0]]):
            assert all(abs(here[n] - there[n]) <= steps[n] * (1.0 + 1e-9) for n in moves)
        largest = max(largest, radius_of_path([np.real(loop.matrix(one)) for one in values]))
    if stable.status == "proved":
        assert largest < 1.0
    if decays.status == "proved":
        assert largest <= math.exp(-rate * period) * (1.0 + 1e-9)
    for proof, most in ((stable, 1.0), (decays, math.exp(-rate * period))):
        if proof.counterexample is not None:
            assert loop.radius(loop.values | dict(proof.counterexample)) > most - 1e-9


@pytest.mark.exhaustive
@pytest.mark.parametrize("percent", [10, 60, 150])
def test_the_worst_paths_of_a_swing_decay_where_it_is_proved(percent: int) -> None:
    loop = swing(0.1)
    found = changing(loop, f"{percent} %/s", seconds=200.0)
    assert found.proofs[0].status == "proved"
    step = percent * 100.0 / RATE
    assert greedy(of_stiffness(loop), 1e3, step, 10_000) < 0.0


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(10))
def test_random_swings_decay_where_several_norms_prove_it(seed: int) -> None:
    draw = random.Random(seed)
    loop = swing(draw.uniform(0.07, 0.12))
    loop.values["first.damping"] = draw.uniform(2.5, 6.0)
    part = draw.uniform(0.05, 0.6)
    found = changing(loop, f"{100.0 * part} %/s", seconds=60.0).proofs[0]
    assert found.status == "proved"
    step, width = part * 1e4 / RATE, 1e4 * loop.tolerances[STIFFNESS]
    matrix = of_stiffness(loop)
    assert max(radius_of_path(list(map(matrix, path))) for path in waves(width, step, 200)) < 1.0
    assert greedy(matrix, width, step, 4000) < 0.0
    assert len(found.searched.leaves) > 1


# -- one that changes, and one that stays ------------------------------------------------------------------------------


@pytest.mark.exhaustive
def test_parameters_without_a_rate_stay_as_they_are() -> None:
    loop = swing(0.06)
    loop.tolerances["gain.gain"] = 0.3
    found = changing(loop, {STIFFNESS: "20 N*m/rad/s"}, seconds=120.0)
    assert status(found) == ["proved"] * 3
    place = [one.written for one in found.ranges].index("gain.gain")
    assert found.as_data()["rates"] == [20.0 if one.written == STIFFNESS else 0.0 for one in found.ranges]
    for leaf in found.proofs[0].searched.leaves:
        assert leaf.core[place] == leaf.box[place]
        assert leaf.core[1 - place] != leaf.box[1 - place] or leaf.box[1 - place] == (9400.0, 10600.0)
    assert check_certificate(certificate(found))
    both = changing(loop, {"": "0.2 %/s", "gain.gain": "1 %/s"}, seconds=0.0)
    assert both.rates == tuple(20.0 if one.written == STIFFNESS else 0.01 for one in both.ranges)


@pytest.mark.exhaustive
def test_one_divided_by_a_parameter_moves_by_more() -> None:
    """d(1 / J) is at most dJ / J^2 at the least J: the accelerometer's matrix bends less along 1 / J."""
    graph = read_graph("library:closed_loop_accelerometer")
    tolerances = {"torquer.gain": "10 %", "pendulum.inertia": "10 %"}
    found = prove(graph, tolerances=tolerances, slow_change="5 %/s", gain_margin="20 dB", workers=1)
    assert status(found) == ["proved"] * 3
    claim = found.proofs[0].claim
    inertia = [one.written for one in found.ranges].index("pendulum.inertia")
    assert found.proofs[0].coordinates is not None
    assert found.proofs[0].coordinates.inverse[inertia]
    assert claim.changes[inertia] == pytest.approx(0.05e-7 * claim.period / 0.9e-7**2, rel=1e-12)
    assert check_certificate(certificate(found))[0].count(" a period") == 2


def test_sums_of_what_comes_in_need_one_norm_and_some_claims_are_of_parameters_that_stay() -> None:
    given: dict[str, Any] = {"input": "step.output", "peak": {"hold.output": 1.2}, "scale_factor": {"hold.output": ""}}
    found = prove(GRAPH, tolerances={"gain.gain": "10 %"}, slow_change="1 %/s", delay_margin="1 ms", **given)
    answers = {one.claim.kind: one for one in found.proofs}
    assert answers["peak"].status == "proved"
    assert str(answers["peak"].claim) == "peak of at most 1.2 under slow change"
    assert all("parameters that stay" in answers[kind].searched.why for kind in ("scale factor", "delay margin"))
    assert check_certificate(certificate(found))[-1].startswith(
        "step.output to hold.output, peak of at most 1.2 under slow"
    )


# -- certificates ------------------------------------------------------------------------------------------------------


@pytest.mark.exhaustive
def test_workers_and_a_second_call_find_the_same(slow: Proofs, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "WORTH_SECONDS", -1.0)
    assert certificate(changing(swing(0.1), "30 %/s", workers=2)) == certificate(slow)
    known = known_proofs(certificate(slow), graph_digest(slow.graph))
    monkeypatch.setattr(Norm, "improved", lambda norm: pytest.fail("what is proved is searched again"))
    again = changing(swing(0.1), "30 %/s", known=known)
    assert status(again) == ["proved"] * 3


def _faster(c: Any) -> None:
    c["claims"][0]["changes"] = [100.0 * change for change in c["claims"][0]["changes"]]


def _larger_discs(c: Any) -> None:
    for leaf in c["claims"][0]["leaves"]:
        leaf["disc"][2] = 1.0


def _another_size(c: Any) -> None:
    transform = c["claims"][0]["leaves"][1]["transform"]
    c["claims"][0]["leaves"][1]["transform"] = [[1e4 * value for value in row] for row in transform]


def _no_room(c: Any) -> None:
    """Norms that serve the cores alone, and are left at once."""
    for leaf in c["claims"][0]["leaves"]:
        loop = c["loops"][leaf["loop"]]
        c["loops"].append(loop | {"box": leaf["box"][:-1]})
        leaf["loop"] = len(c["loops"]) - 1


def _back(c: Any) -> None:
    c["claims"][0]["changes"] = [-1.0]


def _any_change(c: Any) -> None:
    c["claims"][0]["any_change"] = True


@pytest.mark.parametrize("change", [_faster, _larger_discs, _another_size, _no_room, _back, _any_change])
def test_norms_that_follow_each_other_too_soon_prove_nothing(slow: Proofs, change: Any) -> None:
    with pytest.raises(FalseCertificateError, match="follows another so soon"):
        check_certificate(forged(certificate(slow), change))


def _narrower_box(c: Any) -> None:
    leaf = c["claims"][0]["leaves"][0]
    (low, high), _ = leaf["box"]
    c["loops"][leaf["loop"]]["box"] = [[low, 0.5 * (low + high)]]


def _smaller_disc(c: Any) -> None:
    c["claims"][0]["leaves"][0]["disc"][2] *= 0.99


def _one_leaf_less(c: Any) -> None:
    del c["claims"][0]["leaves"][0]


def _two_rates(c: Any) -> None:
    c["claims"][0]["changes"] *= 2


def _not_a_number(c: Any) -> None:
    c["claims"][0]["changes"] = ["fast"]


REFUSED = {
    "another box": _narrower_box,
    "does not contract": _smaller_disc,
    "leave a gap": _one_leaf_less,
    "cannot be read: zip": _two_rates,
    "cannot be read: Invalid literal": _not_a_number,
}


@pytest.mark.parametrize("why", REFUSED)
def test_other_forgeries_are_refused(slow: Proofs, why: str) -> None:
    with pytest.raises(FalseCertificateError, match=why):
        check_certificate(forged(certificate(slow), REFUSED[why]))


def test_what_holds_under_slow_change_holds_for_parameters_that_stay(slow: Proofs) -> None:
    lines = check_certificate(forged(certificate(slow), lambda c: [one.pop("changes") for one in c["claims"]]))
    assert lines[0].startswith("main, stable: ")
    assert " a period" not in lines[0]


# -- what is written ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rate", "words"),
    [
        ("1 %", "is not a rate of change"),
        ("1 V/s", "is not a rate of change"),
        ("fast", "is not a rate of change"),
        ("0 %/s", 'is not a rate above zero(.|\\n)*"1 %/s"'),
        ("-1 %/s", "is not a rate above zero"),
        ([1.0], "is not a rate of change"),
        ({"gain.gai": "1 %/s"}, "did you mean gain.gain"),
        ({"hold.gain": "1 %/s"}, "has no tolerance, and so does not change"),
        ({"gain.gain": "1 V"}, "slow_change.gain.gain"),
    ],
)
def test_what_is_no_rate_is_refused(rate: Any, words: str) -> None:
    with pytest.raises(ModelError, match=words) as raised:
        prove(GRAPH, tolerances={"gain.gain": "10 %"}, slow_change=rate)
    assert all(problem.key.startswith("slow_change") and problem.code for problem in raised.value.problems)


def test_changes_are_slow_or_any() -> None:
    with pytest.raises(ModelError, match="change at will"):
        prove(GRAPH, tolerances={"gain.gain": "10 %"}, slow_change="1 %/s", any_change=True)


@pytest.mark.exhaustive
def test_the_command_takes_rates(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["prove", "library:closed_loop_accelerometer", "--tolerance", "torquer.gain=10 %"]
    assert main([*words, "--slow-change", "1 %/s"]) == 0
    shown = capsys.readouterr().out
    assert "stable under slow change" in shown
    assert "which changes by at most 0.00065 N·m/A in a second" in shown
    assert main([*words, "--slow-change", "torquer.gain=0.001 N*m/A/s"]) == 0
    assert "which changes by at most 0.001 N·m/A in a second" in capsys.readouterr().out
    assert main([*words, "--slow-change", "pickoff.gain=1 %/s"]) == 1
    assert "pickoff.gain: has no tolerance" in capsys.readouterr().err
