"""Proofs on orbits: closed forms, brute force over random points, what does not come round, forged certificates."""

import math
import random
from contextlib import nullcontext
from typing import Any

import flint
import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.derivatives.ball import BITS, Ball, ball
from proofmass.runner.derivatives.polynomial import PolynomialBall
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.prove import Proofs, prove, prove_margin
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.design.proof.rest_sources import RestSources
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.orbiting_loops import (
    AVERAGED,
    DEMODULATED,
    MixedLoop,
    averaged_margin,
    carrier_of,
    demodulated_margin,
    demodulated_orbit,
)
from tests.by_hand.taylor_models import number_at
from tests.runner.design.proof.test_prove import status
from tests.runner.verification.test_certificates import forged

WITHIN = {"level.value": "5 %", "gain.gain": "5 %"}
LOOP = read_graph_text(DEMODULATED)
SINE = 'kind = "Sine"\nfrequency = "250 Hz"'
LEAST = demodulated_margin(1.05, 105.0)  # of all sensors within
CORNERS = [(level, gain) for level in (0.95, 1.05) for gain in (95.0, 105.0)]


def in_decibels(factor: float) -> float:
    return 20.0 * math.log10(factor)


def found(graph: Graph = LOOP, **given: Any) -> Proofs:
    usual: dict[str, Any] = {"tolerances": WITHIN, "phase_margin": "20 deg", "seconds": 120.0, "workers": 1}
    return prove(graph, **(usual | given))


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return found(gain_margin=f"{in_decibels(LEAST) - 0.05} dB")


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_a_gain_margin_is_proved_up_to_its_closed_form(proved: Proofs) -> None:
    assert status(proved) == ["proved"] * 3
    assert all(str(one.claim).endswith(" on an orbit of 4 ms") for one in proved.proofs)


def test_a_gain_margin_beyond_its_closed_form_is_refuted_by_a_sensor() -> None:
    beyond = prove_margin(LOOP, "main", "gain margin", in_decibels(LEAST) + 0.05, WITHIN, at="settled")
    assert beyond.status == "refuted"
    sensor = beyond.counterexample or {}
    assert in_decibels(demodulated_margin(sensor["level.value"], sensor["gain.gain"])) < in_decibels(LEAST) + 0.05


@pytest.mark.defect("S821", before="ended with an error of NumPy", after="has the margins of the closed form")
def test_margins_on_an_orbit_whose_integrator_lets_a_line_not_through() -> None:
    planned = plan(LOOP)
    about = RestRun(planned, [("plant", "output")], Course(planned)).linearised(planned)
    found_there = margins_of(about.loop(("plant", "output")), "main", "plant.output")
    assert found_there.gain_margin == pytest.approx(demodulated_margin(1.0, 100.0), rel=1e-9)


def test_the_orbit_is_enclosed_and_a_run_comes_to_it() -> None:
    node, given = ("plant", "output"), {"level.value": (0.95, 1.05), "gain.gain": (95.0, 105.0)}
    rest = RestRun(plan(LOOP), [node], Course(plan(LOOP)))
    assert rest.periods == 4
    assert rest.orbit == pytest.approx(4e-3)
    with flint.ctx.workprec(BITS):
        there = [one.ends() for one in rest.enclosed({name: ball(*ends) for name, ends in given.items()}).values]
    for level, gain in ((0.95, 95.0), (0.95, 105.0), (1.05, 95.0), (1.05, 105.0), (1.0, 101.0)):
        run = simulate(LOOP.with_parameters({"level.value": level, "gain.gain": gain}))
        last = run.traces["plant.output"].values[-4:]
        orbit = demodulated_orbit(level, gain)
        assert sorted(last) == pytest.approx(sorted(orbit * 2), rel=1e-9)
        for number, (low, high) in enumerate(there):
            assert low < orbit[(rest.tick + number) % 2] < high


def test_an_orbit_lies_within_the_reach_of_its_curve() -> None:
    """At random places of the box; what is left out is a part of 1e-4 of how far the orbit moves."""
    rest, draw = RestRun(plan(LOOP), [("plant", "output")], Course(plan(LOOP))), random.Random(3)
    with flint.ctx.workprec(BITS):
        sides = {
            "level.value": PolynomialBall.coordinate(0.95, 1.05, 0),
            "gain.gain": PolynomialBall.coordinate(95.0, 105.0, 1),
        }
        found = rest.enclosed(sides)
        for parts in [
            (1, 1),
            (-1, 1),
            (1, -1),
            (-1, -1),
            *((draw.uniform(-1, 1), draw.uniform(-1, 1)) for _ in range(20)),
        ]:
            orbit = demodulated_orbit(1.0 + 0.05 * parts[0], 100.0 + 5.0 * parts[1])
            for number, value in enumerate(found.values):
                low, high = Ball(number_at(value, parts)).ends()
                assert low < orbit[(rest.tick + number) % 2] < high
                assert high - low < 1e-5


@pytest.mark.parametrize("off", chosen([0.01], [-0.01]))
def test_a_mean_and_a_decay_rate_on_an_orbit(off: float) -> None:
    """x is u's at one end of each step and k u lower at the other."""
    means = [sum(demodulated_orbit(*one)) / 2.0 for one in CORNERS]
    rate = min(
        -math.log(1.0 - 1e-3 * gain * (1.0 + demodulated_orbit(level, gain)[1])) / 2e-3 for level, gain in CORNERS
    )
    ends = [min(means) * (1.0 - off), max(means) * (1.0 + off)]
    answer = found(loop="main", decay_rate=f"{rate * (1.0 - off)} 1/s", bias={"plant.output": ends})
    assert status(answer)[3:] == ["proved" if off > 0 else "refuted"] * 3
    assert "bias of at most" in proofs_text(answer)


@pytest.mark.exhaustive
def test_a_scale_factor_on_an_orbit() -> None:
    """dx1 / du = 2 / (1 + x1)."""
    slopes = [2.0 / (1.0 + demodulated_orbit(*one)[1]) - 5e-4 * one[1] for one in CORNERS]
    factors = [0.99 * min(slopes), 1.01 * max(slopes)]
    found = prove(LOOP, tolerances=WITHIN, at="settled", input="level.output", scale_factor={"plant.output": factors})
    assert status(found) == ["proved", "proved"]


@pytest.mark.exhaustive
@pytest.mark.parametrize("source", ["pulses", "a counter"])
def test_pulses_and_counts_come_round_too(source: str) -> None:
    text = DEMODULATED.replace(SINE, 'kind = "Pulse"\nrepetition = "2 ms"')
    if source == "a counter":
        wires = '"one.output -> carrier.first", "none.output -> carrier.second", "turn.carry -> carrier.choose_first", '
        text = DEMODULATED.replace(SINE, 'kind = "Switch"').replace("wires = [", f"wires = [{wires}")
        text += '[blocks.one]\nkind = "Constant"\nvalue = 1.0\n[blocks.none]\nkind = "Constant"\nvalue = 0.0\n'
        text += '[blocks.turn]\nkind = "Counter"\nmodulus = 2\n'
    graph = read_graph_text(text)
    near = found(graph, gain_margin=f"{in_decibels(LEAST) - 0.05} dB")
    assert status(near) == ["proved"] * 3
    assert {one.claim.orbit for one in near.proofs} == {2e-3}
    assert status(found(graph, gain_margin=f"{in_decibels(LEAST) + 0.05} dB"))[1] == "refuted"


@pytest.mark.exhaustive
@pytest.mark.parametrize("off", [-0.05, 0.05])
def test_coefficients_are_those_of_each_sensor(off: float) -> None:
    """The reference of the demodulator is a buffer that no tick changes, and follows from the phase."""
    graph, within = read_graph_text(AVERAGED), {"demodulator.phase": [0.4, 0.6], "level.value": "5 %"}
    least = min(averaged_margin(level, 25.0, phase) for level in (0.95, 1.05) for phase in (0.4, 0.6))
    assert averaged_margin(1.05, 25.0, 0.5) > 1.03 * least  # the phase counts
    answer = found(graph, tolerances=within, gain_margin=f"{in_decibels(least) + off} dB", phase_margin="5 deg",
                   at="settled")  # fmt: skip
    assert status(answer)[:2] == ["proved", "proved" if off < 0 else "refuted"]


# -- brute force -------------------------------------------------------------------------------------------------------

NAMES = {"level": "level.value", "gain": "gain.gain", "shake": "shake.gain", "depth": "depth.gain"}


@pytest.mark.parametrize("seed", chosen((1,), (0, *range(2, 24))))
def test_random_loops_have_no_false_proof(seed: int) -> None:
    """Corners and random places of a box, with factors at the wire, by a program of its own."""
    rng = random.Random(seed)
    ticks = rng.randint(2, 6)
    cycles, phase, width = rng.randint(1, ticks - 1), rng.choice([0.0, rng.uniform(0.0, 6.28)]), rng.choice([0.02, 0.1])
    middle = {
        "level": rng.uniform(-0.3, 1.5), "shake": rng.uniform(0.0, 1.0), "depth": rng.uniform(0.0, 1.2),
        "gain": rng.uniform(50.0, 700.0), "bend": rng.uniform(-0.2, 0.4),
    }  # fmt: skip
    names = rng.sample(sorted(NAMES), 2)
    answer = prove(
        MixedLoop(**middle).graph(cycles, ticks, phase),
        tolerances={NAMES[name]: f"{100.0 * width} %" for name in names},
        gain_margin="3 dB", phase_margin="1 deg", seconds=8.0, at="settled", workers=1,
    )  # fmt: skip
    carrier, limits = carrier_of(cycles, ticks, phase), ([1.0], [10.0 ** (0.15 * side) for side in (-1, 0, 1)])
    for proof, factors in zip(answer.proofs[:2], limits, strict=True):
        if proof.status == "proved":
            for number in range(40):
                place = [rng.choice([-1.0, 1.0]) if number < 8 else rng.uniform(-1.0, 1.0) for _ in names]
                moved = {name: middle[name] * (1.0 + width * by) for name, by in zip(names, place, strict=True)}
                poles = [MixedLoop(**(middle | moved)).largest_pole(carrier, factor) for factor in factors]
                assert max(poles) < 1.0
        elif proof.status == "refuted":
            sensor = proof.counterexample or {}
            moved = {name: sensor.get(NAMES[name], middle[name]) for name in names}
            assert max(MixedLoop(**(middle | moved)).largest_pole(carrier, factor) for factor in factors) > 1.0 - 1e-6


@pytest.mark.exhaustive
def test_a_push_decays_in_runs_of_proved_sensors() -> None:
    """A run that begins elsewhere comes to the same orbit, at least as fast as is proved."""
    loop = MixedLoop(gain=150.0)
    answer = found(loop.graph(1, 4, 0.3), tolerances=WITHIN, decay_rate="60 1/s", gain_margin="6 dB")
    assert status(answer) == ["proved"] * 4
    for level in (0.95, 1.05):
        for gain in (142.5, 157.5):
            sensor = MixedLoop(level=level, gain=gain)
            values = simulate(sensor.graph(1, 4, 0.3)).traces["plant.output"].values
            apart = np.abs(values[:-4:4] - values[4::4])[5:25]
            assert apart[-1] <= 1.5 * apart[0] * math.exp(-60.0 * 4e-3 * (len(apart) - 1))


@pytest.mark.exhaustive
def test_a_box_with_an_unstable_sensor_is_never_proved() -> None:
    """At a gain of 1000 the slope is (1 - 2.236)^2: the orbit of two ticks is there, and what is near leaves it."""
    graph = read_graph_text(DEMODULATED.replace(SINE, 'kind = "Pulse"\nrepetition = "2 ms"'))
    assert "proved" not in status(found(graph, tolerances={"gain.gain": [90.0, 1000.0]}, seconds=5.0))
    unstable = graph.with_parameters({"gain.gain": 1000.0})
    assert "proved" not in status(found(unstable, tolerances={}, at="settled", seconds=5.0))


def test_an_orbit_that_doubles_its_period_is_that_of_the_run() -> None:
    """A carrier of four ticks leaves room for an orbit in which each second turn differs: that one is stable."""
    graph = LOOP.with_parameters({"gain.gain": 1000.0})
    assert status(found(graph, tolerances={}, at="settled"))[0] == "proved"
    last = simulate(graph).traces["plant.output"].values[-5:]
    assert last[0] == pytest.approx(last[4], rel=1e-9)
    assert abs(last[0] - last[2]) > 0.1


# -- what does not come round ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("source", "given", "words"),
    [
        (SINE.replace("250", "251"), {}, "at most 64 periods"),
        (SINE, {"tolerances": {"carrier.frequency": "1 %"}}, "a source changes with time"),
        ('kind = "Chirp"\nstart_frequency = "1 Hz"\nstop_frequency = "90 Hz"', {}, "sources change with time"),
        ('kind = "Pulse"\nrepetition = "2 ms"\ndelay = "1000 s"', {}, "sources change with time"),
        (SINE, {"any_change": True}, "parameters that stay as they are"),
    ],
    ids=["no whole cycles", "a frequency that varies", "chirp", "pulses that begin later", "any change"],
)
def test_what_does_not_come_round_is_open_with_the_reason(source: str, given: Any, words: str) -> None:
    graph = read_graph_text(DEMODULATED.replace(SINE, source))
    answer = found(graph, at="settled", **({"tolerances": WITHIN, "seconds": 60.0} | given))
    assert set(status(answer)) == {"open"}
    assert all(words in one.searched.why for one in answer.proofs)


@pytest.mark.parametrize(
    ("periods", "whole"), [((64,), True), ((65,), False), ((21, 3), True), ((9, 7), True), ((9, 8), False)]
)
def test_sources_come_round_together_within_64_periods(periods: tuple[int, ...], whole: bool) -> None:
    """Sines of some periods of 1 ms each."""
    blocks = "".join(f'[blocks.s{n}]\nkind = "Sine"\nfrequency = "{1000 / n!r} Hz"\n' for n in periods)
    sines = plan(read_graph_text(f'name = "sines"\nrate = "1 kHz"\n{blocks}'))
    with nullcontext() if whole else pytest.raises(ModelError, match="at most 64 periods"):
        RestSources(sines, {*sines.blocks}).check("s", 1, 0)


# -- certificates ------------------------------------------------------------------------------------------------------


@pytest.mark.exhaustive
def test_a_certificate_says_on_which_orbit_and_is_taken_up_again(proved: Proofs) -> None:
    text = certificate(proved)
    assert check_certificate(text)[0].startswith("main, stable on an orbit of 0.004 s: 1 box, ")
    again = found(gain_margin=f"{in_decibels(LEAST) - 0.05} dB", known=known_proofs(text, graph_digest(LOOP)))
    assert check_certificate(certificate(again)) == check_certificate(text)


def _rest_of(c: Any) -> Any:
    return c["loops"][c["claims"][0]["leaves"][0]["loop"]]["rest"]


def _changed(name: str, change: Any) -> Any:
    def forge(c: Any) -> None:
        _rest_of(c)[name] = change(_rest_of(c)[name])

    return forge


def _without(c: Any) -> None:
    del c["loops"][c["claims"][0]["leaves"][0]["loop"]]["rest"]


def _shorter(c: Any) -> None:
    """One point of the orbit alone."""
    rest = _rest_of(c)
    for name in ("centre", "reach", "step", "step_radius"):
        rest[name] = rest[name][:1]


def _at_the_start(c: Any) -> None:
    c["claims"][0]["at_rest"] = False


FORGERIES = [
    _without, _shorter, _at_the_start, _changed("reach", lambda r: [0.5 * x for x in r]),
    _changed("step_radius", lambda b: [x + 10.0 for x in b]), _changed("step", lambda b: [x + 1.0 for x in b]),
    _changed("left", lambda m: [[-x for x in row] for row in m]),
    _changed("matrix", lambda j: [[x + 0.5 for x in row] for row in j]),
    _changed("matrix", lambda j: [*j[1:], j[0]]),
    _changed("matrix_radius", lambda j: [[x + 1.0 for x in row] for row in j]),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(FORGERIES)))
def test_forged_orbits_are_refused(proved: Proofs, number: int) -> None:
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(certificate(proved), FORGERIES[number]))
