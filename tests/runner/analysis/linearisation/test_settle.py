"""When loops have come to rest: against time constants, and what is said of loops that never do."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

import proofmass
from proofmass import margins
from proofmass.blocks import (
    Constant,
    Delay,
    Difference,
    DiscreteIntegrator,
    DiscreteMassSpringDamper,
    Gain,
    LookUpTable,
    LowPass,
    Product,
    Ramp,
    Saturation,
    Sine,
    Step,
    Sum,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.forward import Course, Forward, MachineCode
from proofmass.runner.analysis.linearisation.settle import MOST, TOLERANCE, settled_tick
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan


def loop(gain: float, source: Block, *more: str, rate: float = 1000.0) -> Graph:
    """x[n+1] = x[n] + T (u - gain x[n]): at rest u / gain, with the time constant 1 / gain."""
    blocks: dict[str, Block] = {
        "source": source,
        "sum": Sum(),
        "integral": DiscreteIntegrator(output_unit="1", gain=1.0),
        "back": Gain(gain=-gain),
    }
    wires = ["source.output -> sum.first", "back.output -> sum.second", "sum.output -> integral.input"]
    return Graph(name="loop", rate=rate, blocks=blocks, wires=[*wires, "integral.output -> back.input", *more])


@pytest.mark.parametrize("constant", [0.02, 0.1, 0.5])
def test_a_time_constant_has_gone_by_often_enough(constant: float) -> None:
    """What is left is below the tolerance at the third last time that was tried, and above it before."""
    tick = settled_tick(Course(plan(loop(1.0 / constant, Constant(value=3.0)))))
    third, fourth = ((1.0 - 1e-3 / constant) ** (tick / part) for part in (1.875**2, 1.875**3))
    assert third < TOLERANCE < fourth


def test_a_delay_line_beside_the_loop_need_not_come_to_rest() -> None:
    alone = loop(10.0, Constant(value=3.0))
    beside = {"ramp": Ramp(slope=1e6), "line": Delay(ticks=5)}
    both = replace(alone, blocks={**alone.blocks, **beside}, wires=[*alone.wires, "ramp.output -> line.input"])
    assert settled_tick(Course(plan(both))) == settled_tick(Course(plan(alone)))


def test_a_period_does_not_hide(monkeypatch: pytest.MonkeyPatch) -> None:
    """Driven sixty-four ticks to and fro, or any power of two, the loop is nowhere at rest."""
    monkeypatch.setattr("proofmass.runner.analysis.linearisation.settle.MOST", 1 << 11)
    for period in (4, 16, 64, 256):
        with pytest.raises(ModelError, match="the loops do not settle"):
            settled_tick(Course(plan(loop(10.0, Sine(frequency=1000.0 / period, phase=1.0)))))


def test_the_time_does_not_depend_on_the_ticks() -> None:
    coarse, fine = (
        settled_tick(Course(plan(loop(10.0, Constant(value=3.0), rate=rate)))) / rate for rate in (1e3, 8e3)
    )
    assert 0.5 <= coarse / fine <= 2.0


def test_a_gain_that_depends_on_the_operating_point() -> None:
    """x' = 2 - x^2 comes to rest at sqrt 2, where its pole is at -2 sqrt 2; at tick 0 it is an integrator."""
    blocks: dict[str, Block] = {
        "source": Constant(value=2.0),
        "sum": Sum(),
        "integral": DiscreteIntegrator(output_unit="1", gain=1.0),
        "square": Product(),
        "back": Gain(gain=-1.0),
    }
    wires = [
        "source.output -> sum.first",
        "back.output -> sum.second",
        "sum.output -> integral.input",
        "integral.output -> square.first",
        "integral.output -> square.second",
        "square.output -> back.input",
    ]
    graph = Graph(name="square", rate=1000, blocks=blocks, wires=wires)
    (pole,) = proofmass.margins(graph, "back.output", at="settled").poles
    assert pole.real == pytest.approx(1.0 - 2.0 * math.sqrt(2.0) * 1e-3, rel=1e-7)
    with pytest.raises(ModelError, match="does not come back"):
        proofmass.margins(graph, "back.output", at="0 s")
    assert proofmass.margins(graph, "back.output").poles == pytest.approx([pole])


def test_a_loop_that_is_driven_to_and_fro_does_not_settle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.analysis.linearisation.settle.MOST", 1 << 13)
    with pytest.raises(ModelError, match="the loops do not settle") as caught:
        settled_tick(Course(plan(loop(10.0, Sine(frequency=0.7)))))
    (problem,) = caught.value.problems
    assert "integral." in problem.got
    assert "from 4,857 ticks to 9,107" in problem.got


@pytest.mark.defect("H892", before="`is not finite in tick 1745` of nothing", after="of the output that is")
def test_a_loop_that_diverges_does_not_settle() -> None:
    for gain in (-30.0, 2500.0):
        with pytest.raises(ModelError, match="the loops do not settle") as caught:
            settled_tick(Course(plan(loop(gain, Constant(value=1.0)))))
    assert caught.value.problems[0].got.startswith("back.output is not finite in tick")


@pytest.mark.exhaustive
def test_the_command_says_when(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "loop.toml"
    path.write_text(write_graph(loop(10.0, Constant(value=3.0))))
    command = ["margins", str(path), "--loop", "back.output", "--at"]
    assert main([*command, "settled"]) == 0
    said = capsys.readouterr().out
    assert "settled after " in said
    assert "stable" in said
    assert main([*command, "settled", "--json"]) == 0
    (answer,) = json.loads(capsys.readouterr().out)["loops"]
    assert answer["operating_point"]["found"].startswith("settled after ")
    assert answer["poles"] == [[pytest.approx(0.99), 0.0]]
    assert main([*command, "setled"]) == 1
    assert '"settled"' in capsys.readouterr().err


def beyond_pull_in() -> Graph:
    """A mass on a spring that pushes, 30 / s away from rest, between limits that only hold the force."""
    blocks: dict[str, Block] = {
        "source": Step(amplitude=1e-3),
        "sum": Sum(),
        "speed": DiscreteIntegrator(output_unit="1", gain=1.0),
        "place": DiscreteIntegrator(output_unit="1", gain=1.0),
        "push": Gain(gain=9e4),
        "limit": Saturation(),
    }
    wires = [
        "source.output -> sum.first",
        "limit.output -> sum.second",
        "sum.output -> speed.input",
        "speed.output -> place.input",
        "place.output -> push.input",
        "push.output -> limit.input",
    ]
    return Graph(name="pull-in", rate=1000.0, blocks=blocks, wires=wires)


@pytest.mark.defect("H1", before="over ten minutes without a word", after="given up after 2^20 ticks: unstable")
def test_a_loop_that_is_plainly_unstable_is_given_up() -> None:
    """The pole of 1 + 30 / s grows by 1.03 in a tick of 1 ms, and the limit lets go at once."""
    graph = beyond_pull_in()
    with pytest.raises(ModelError, match="the loops do not settle") as caught:
        settled_tick(Course(plan(graph)))
    (problem,) = caught.value.problems
    assert problem.got.startswith("place.total moves by")
    found = margins(graph, "sum.output")
    assert found.verdict == "unstable"
    assert max(abs(found.poles)) == pytest.approx(1.0 + 1e-3 * math.sqrt(9e4), rel=1e-9)


def test_what_is_unstable_in_tick_0_may_settle() -> None:
    """x[n+1] = x + T (30 x - 30 x^3 + u): away from 0 to 1."""
    blocks: dict[str, Block] = {
        "source": Constant(value=1e-6),
        "sum": Sum(),
        "integral": DiscreteIntegrator(output_unit="1", gain=30.0),
        "square": Product(),
        "cube": Product(),
        "back": Gain(gain=-1.0),
        "both": Sum(),
    }
    wires = [
        "integral.output -> square.first",
        "integral.output -> square.second",
        "square.output -> cube.first",
        "integral.output -> cube.second",
        "cube.output -> back.input",
        "back.output -> both.first",
        "integral.output -> both.second",
        "both.output -> sum.first",
        "source.output -> sum.second",
        "sum.output -> integral.input",
    ]
    graph = Graph(name="two places", rate=1000, blocks=blocks, wires=wires, samples=1000)
    planned = plan(graph)
    tick = settled_tick(Course(planned))
    assert Course(planned).at(tick).states["integral"].total == pytest.approx(1.0, rel=1e-3)
    found = margins(graph, "both.output")
    assert found.stable
    assert max(abs(found.poles)) == pytest.approx(1.0 - 0.06, rel=1e-5), "the slope of 30 x - 30 x^3 at 1 is -60"


def test_progress_is_told() -> None:
    told: list[tuple[int, int]] = []
    settled_tick(Course(plan(loop(10.0, Constant(value=3.0)))), progress=lambda done, of: told.append((done, of)))
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert {of for _, of in told} == {MOST}


def test_plain_python_hands_over_to_machine_code_between_two_ticks(monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(loop(10.0, Sine(frequency=3.0)))
    plain = Forward(planned).to(3000)
    monkeypatch.setattr("proofmass.runner.analysis.linearisation.forward.INTERPRETED", -1e9)
    run = Forward(planned)
    both = run.to(3000, of=10**9)
    assert run.reach(run.tick).name == "compiled"
    assert (both.states, both.wires, both.tick) == (plain.states, plain.wires, 3000)


def test_of_many_short_parts_machine_code_is_asked_for_the_longest(monkeypatch: pytest.MonkeyPatch) -> None:
    run, asked = Forward(plan(loop(10.0, Sine(frequency=3.0)))), list[int]()
    monkeypatch.setattr(MachineCode, "pays", lambda _, ticks: asked.append(ticks))
    for tick in (5, 10, 15, 30, 35):
        run.to(tick)
    assert asked == [5, 15]


def test_a_run_that_fails_on_the_way_is_a_problem_with_its_place() -> None:
    with pytest.raises(ModelError, match="is not finite in tick"):
        proofmass.margins(loop(2500.0, Constant(value=1.0)), "back.output", at="10 s")


@pytest.mark.defect("S27", before="margins about the noise of one seed; settled was refused", after="noise is zero")
@pytest.mark.parametrize("at", ["0.1 s", "settled"])
def test_noise_does_not_move_the_operating_point(at: str) -> None:
    """A loop through y = (x + n)^2 with x = 0.5 at rest: the gain 1, and so a gain margin of 1 / (K T) times 2."""
    blocks = {
        "input": Constant(value=0.25), "error": Difference(), "noise": WhiteNoise(density=3e-3), "sum": Sum(),
        "square": Product(), "integrator": DiscreteIntegrator(gain=100.0, input_unit="1", output_unit="1"),
    }  # fmt: skip
    wires = ["input.output -> error.first", "square.output -> error.second", "error.output -> integrator.input"]
    wires += ["integrator.output -> sum.first", "noise.output -> sum.second"]
    wires += ["sum.output -> square.first", "sum.output -> square.second"]
    graph = Graph(name="noisy", rate=1000, seed=3, blocks=blocks, wires=wires)
    found = margins(graph, "integrator.output", at=at)
    assert found.gain_margin == pytest.approx(2.0 / (2.0 * 0.5 * 0.1), rel=1e-3)


def warming_up(constant: float, first: float, last: float) -> Graph:
    """x' = x + 0.1 (1 - x (1 + 3 T)), T' = T + (T1 - T) / c: at rest a factor of 2 / (0.1 (1 + 3 T1)) is the limit."""
    blocks: dict[str, Block] = {
        "level": Constant(value=1.0), "error": Difference(), "plant": DiscreteIntegrator(gain=100.0, output_unit="1"),
        "end": Constant(value=last), "lag": Difference(),
        "heat": DiscreteIntegrator(gain=1000.0 / constant, output_unit="1", initial=first),
        "one": Constant(value=1.0), "weight": Gain(gain=3.0), "slope": Sum(), "mixer": Product(),
    }  # fmt: skip
    wires = ["level.output -> error.first", "mixer.output -> error.second", "error.output -> plant.input"]
    wires += ["end.output -> lag.first", "heat.output -> lag.second", "lag.output -> heat.input"]
    wires += ["heat.output -> weight.input", "one.output -> slope.first", "weight.output -> slope.second"]
    wires += ["plant.output -> mixer.first", "slope.output -> mixer.second"]
    loops = {"main": {"open_at": "plant.output"}}
    return Graph(name="warming up", rate=1000, blocks=blocks, wires=wires, samples=4000, loops=loops)


@pytest.mark.exhaustive("1.0-0.0")
@pytest.mark.defect("S843", before="settled after 111 ms: 5.04, of 20", after="settled after 211 s: 20.0")
@pytest.mark.parametrize(("first", "last"), [(1.0, 0.0), (0.0, 1.0), (1.0, 2.0), (1.0, 1.2)])
def test_a_slow_mode_is_not_at_rest(first: float, last: float) -> None:
    """With 10,000 ticks, between looks at which it moves by less than the tolerance."""
    found = margins(warming_up(1e4, first, last), at="settled")
    assert found.gain_margin == pytest.approx(20.0 / (1.0 + 3.0 * last), rel=1e-4)


def test_what_is_slower_than_the_longest_run_does_not_settle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.analysis.linearisation.settle.MOST", 1 << 13)
    with pytest.raises(ModelError, match="the loops do not settle") as caught:
        margins(warming_up(1e5, 1.0, 0.0), at="settled")
    (problem,) = caught.value.problems
    assert "heat.total moves by 0.04" in problem.got


def with_a_slow_reference(constant: float, last: float) -> Graph:
    """The loop that warms up, with a filter of the heat outside the loop, which it multiplies and does not move.

    The level is zero, so that nothing in the loop moves at all.
    """
    graph = warming_up(constant, 0.0, last)
    slow = LowPass(corner_frequency=1000.0 / (2.0 * math.pi * constant))
    blocks = {n: b for n, b in graph.blocks.items() if n not in ("lag", "heat")} | {"heat": slow}
    wires = [(w.source, w.target) for w in graph.wires if not {"lag", "heat"} & {w.target.split(".")[0]}]
    wires = [wire for wire in wires if wire[0].split(".")[0] != "lag"] + [("end.output", "heat.input")]
    return Graph(
        name="slow reference", rate=1000, blocks=blocks | {"level": Constant(value=0.0)}, samples=4000,
        wires=[" -> ".join(wire) for wire in wires], loops={"main": {"open_at": "plant.output"}},
    )  # fmt: skip


@pytest.mark.exhaustive
@pytest.mark.defect("S844", before="settled after 111 ms: 13.2, of 5", after="settled after 59 s: 5.0")
def test_a_slow_filter_before_a_loop_is_not_at_rest() -> None:
    found = margins(with_a_slow_reference(3e3, 1.0), at="settled")
    assert found.gain_margin == pytest.approx(5.0, rel=1e-3)


def with_a_knee(table: tuple[float, ...], limited: bool = False) -> Graph:
    """x' = x + 0.1 f(1 - x) from 0 to 1, where f(0) = 0; f has the values of a table at -1, 0.1 and 3."""
    blocks: dict[str, Block] = {
        "level": Constant(value=1.0), "error": Difference(),
        "curve": LookUpTable(breakpoints=(-1.0, 0.1, 3.0), values=table, extrapolated=True),
        "plant": DiscreteIntegrator(gain=100.0, output_unit="1", limited=limited, highest=0.5),
    }  # fmt: skip
    wires = ["level.output -> error.first", "plant.output -> error.second", "error.output -> curve.input"]
    wires += ["curve.output -> plant.input"]
    loops = {"main": {"open_at": "plant.output"}}
    return Graph(name="knee", rate=1000, blocks=blocks, wires=wires, samples=4000, loops=loops)


@pytest.mark.defect("S845", before="at the start: 200, of 4", after="settled: 4")
def test_a_loop_that_is_another_at_the_end_of_its_run_was_starting_up() -> None:
    """The slope is 0.1 until the error is 0.1, and 5 below."""
    found = margins(with_a_knee((-5.0, 0.5, 0.79)))
    assert found.gain_margin == pytest.approx(4.0, rel=1e-9)
    assert found.system.map.told.startswith("settled after")


@pytest.mark.defect("S845", before="at the start: 200, without a note", after="with the note that it starts up")
def test_a_loop_that_comes_to_a_limit_has_a_note() -> None:
    found = margins(with_a_knee((-0.1, 0.01, 0.3), limited=True))
    assert found.gain_margin == pytest.approx(200.0, rel=1e-9)
    assert any("tick 0 is a start-up" in note for note in found.system.map.notes)


def test_a_loop_that_moves_and_stays_the_same_is_told_at_its_start() -> None:
    found = margins(with_a_knee((-0.1, 0.01, 0.3)))
    assert (found.system.map.told, found.system.map.notes) == ("", ())
    assert found.gain_margin == pytest.approx(200.0, rel=1e-9)


def behind(source: LowPass) -> Graph:
    """A product of a signal and what a filter makes of 0.96: its gain."""
    blocks = {"level": Constant(value=0.96), "slow": source, "signal": Constant(), "product": Product()}
    wires = ["level.output -> slow.input", "slow.output -> product.first", "signal.output -> product.second"]
    measured = {"last": {"signal": "product.output", "statistic": "mean"}}
    return Graph(name="slow", rate=1000, blocks=blocks, wires=wires, samples=9000, measures=measured)


@pytest.mark.defect("S980", before="a graph without loops settled after 111 ticks: 0.48 for 0.96", after="at rest")
@pytest.mark.parametrize("constant", [0.02, 0.2])
def test_a_graph_without_loops_settles_too(constant: float) -> None:
    """What is left of a step decays as exp(-t / T); a mean goes on, and moves nothing."""
    graph = behind(LowPass(corner_frequency=1.0 / (2.0 * math.pi * constant)))
    tick = settled_tick(Course(plan(graph)))
    assert math.exp(-1e-3 * tick / constant) < 1e-6
    found = proofmass.response(graph, "signal.output", "product.output", at="settled", frequencies=[1.0])
    assert abs(found.gain[0]) == pytest.approx(0.96, rel=1e-6)


@pytest.mark.defect("S980", before="an integral that goes on had settled after 111 ticks", after="refused, and named")
def test_a_graph_without_loops_may_not_settle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.analysis.linearisation.settle.MOST", 1 << 11)
    blocks = {"level": Constant(value=1.0), "integral": DiscreteIntegrator(output_unit="1")}
    graph = Graph(name="endless", rate=1000, blocks=blocks, wires=["level.output -> integral.input"])
    with pytest.raises(ModelError, match="does not settle") as caught:
        settled_tick(Course(plan(graph)))
    assert caught.value.problems[0].got.startswith("integral.total")


@pytest.mark.defect("S988", before="2.0518, of a ring that swings", after="2.0532, at rest")
def test_what_swings_has_not_settled() -> None:
    """A ring of 5 Hz decays in 64 ms; at rest x = F / k, and the square of it has the slope 2 F / k^2."""
    stiffness = 1e-6 * (2.0 * math.pi * 5.0) ** 2
    blocks: dict[str, Block] = {
        "force": Constant(value=1e-6, unit="N"),
        "mass": DiscreteMassSpringDamper(mass=1e-6, damping=1e-6 * 2.0 * math.pi * 5.0, stiffness=stiffness),
        "square": Product(first_unit="m", second_unit="m"),
    }
    wires = ["force.output -> mass.force", "mass.displacement -> square.first", "mass.displacement -> square.second"]
    graph = Graph(name="ring", rate=2e4, blocks=blocks, wires=wires)
    found = proofmass.response(graph, "force.output", "square.output", at="settled", frequencies=[1.0])
    assert found.at_rest == pytest.approx(2e-6 / stiffness**2, rel=1e-6)
