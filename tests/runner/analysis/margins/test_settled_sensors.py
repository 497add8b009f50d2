"""Margins of many sensors whose loops settle first: against the certified path, alone and together, in any order."""

import numpy as np
import pytest

import proofmass
from proofmass.graphs.model.changes import changed_blocks
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.poles import judged
from proofmass.runner.analysis.margins.many import ManyMargins, margins_alone
from proofmass.runner.analysis.margins.side_by_side import OpenLoops, neutral_mode, responses
from proofmass.runner.planning.plan import plan, varied
from tests.by_hand.lagging_loop import lagging
from tests.runner.analysis.margins.test_many import lot

ALONE = "proofmass.runner.analysis.margins.many.margins_alone"
DRIVE = "drive.loop_filter", "control"


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("at_once", [0.0, 0.05], ids=["no gain at the start", "another gain in the next tick"])
def test_loops_that_settle_are_those_of_the_certified_path(at_once: float, monkeypatch: pytest.MonkeyPatch) -> None:
    planned, sensors = lot(lagging(at_once), {"gain.gain": 0.1}, 3)
    alone = margins_alone(sensors[-1], "auto")
    many = ManyMargins(planned, "auto")
    monkeypatch.setattr(ALONE, None)
    together = many.values(sensors)
    assert together[-1] == pytest.approx(alone, rel=1e-12)
    assert many.values(sensors[::-1])[::-1] == together
    assert [many.values([sensor])[0] for sensor in sensors] == together


@pytest.mark.exhaustive
def test_a_study_has_one_digest_for_any_threads_and_lanes() -> None:
    spread = {"gain.gain": {"normal": 0.3, "relative": True}}
    study = proofmass.Study(lagging(0.05), runs=12, margins="auto", seed=3, spread=spread)
    first = proofmass.run_study(study, engine="python", threads=1)
    assert np.isfinite(first["main.gain_margin"]).all()
    for threads, lanes in ((1, 0), (2, 0), (8, 4), (2, 16)):
        again = proofmass.run_study(study, engine="compiled", threads=threads, lanes=lanes)
        assert again.digest == first.digest


def test_the_gain_margin_is_that_of_the_level_at_the_end() -> None:
    """z - 1 + g f is stable up to f = 2 / g, where the level has come to 1."""
    planned, sensors = lot(lagging(), {"gain.gain": 0.1}, 3)
    for sensor, values in zip(sensors, ManyMargins(planned, "auto").values(sensors), strict=True):
        assert not isinstance(values, proofmass.ModelError)
        gain = sensor.blocks["gain"].gain  # type: ignore[attr-defined]
        assert values[0] == pytest.approx(20.0 * np.log10(2.0 / gain), abs=1e-3)


def test_a_sensor_that_does_not_start_up_is_taken_alone() -> None:
    """Its level comes up so slowly that it is still that of the start where the loop would matter."""
    planned = plan(lagging(0.05))
    slow = {"level.numerator": (1.0, -0.95)}  # the level is 1 from the start
    sensor = varied(planned, changed_blocks(planned.blocks, slow))
    (values,) = ManyMargins(planned, "auto").values([sensor])
    assert values == pytest.approx(margins_alone(sensor, "auto"), rel=1e-12)


def test_where_a_switch_may_follow_only_sensors_that_settle_alike_go_together() -> None:
    """The step comes at tick 500; a loop with a time constant of 100 ticks settles behind it."""
    planned, sensors = lot(lagging(0.05, late=0.5), {"gain.gain": 0.1}, 2)
    many = ManyMargins(planned, "settled")
    slow = varied(planned, changed_blocks(planned.blocks, {"gain.gain": 0.01}))
    for sensor, values in zip([*sensors, slow], many.values([*sensors, slow]), strict=True):
        assert values == pytest.approx(margins_alone(sensor, "settled"), rel=1e-9, nan_ok=True)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["closed_loop_gyroscope", "disk_resonator_gyroscope"])
def test_gyroscopes_of_the_gallery(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(proofmass.read_graph(f"library:{name}"))
    gains = [n for n, block in planned.blocks.items() if isinstance(getattr(block, "gain", None), float)]
    dice = np.random.default_rng(1)
    drawn = [{f"{n}.gain": planned.blocks[n].gain * (1.0 + 0.03 * dice.normal()) for n in gains} for _ in range(4)]  # type: ignore[attr-defined]
    sensors = [varied(planned, changed_blocks(planned.blocks, draw)) for draw in drawn]
    alone = [margins_alone(sensor, "auto") for sensor in sensors]
    many = ManyMargins(planned, "auto")
    monkeypatch.setattr(ALONE, None)
    together = many.values(sensors)
    for values, expected in zip(together, alone, strict=True):
        assert values == pytest.approx(expected, rel=1e-9)
    assert [many.values([sensor])[0] for sensor in sensors] == together


@pytest.mark.defect("S803", before="unstable, by a phase that no loop moves", after="marginal: rounding")
def test_a_neutral_phase_is_not_told_unstable_by_rounding() -> None:
    """The phase of the drive is free: its pole lies at 1, and the carrier's sines put it 4e-14 outside."""
    planned = plan(proofmass.read_graph("library:closed_loop_gyroscope"))
    gains = {"drive.oscillator.gain": 1.0271606760001935, "drive_pickoff.gain": 506695.6185854602}
    sensor = varied(planned, changed_blocks(planned.blocks, gains))
    whole = Ends((DRIVE,), (DRIVE,), cut=True).map(sensor, memory=Course(sensor).at(38_400))
    verdict, poles = judged(np.real(OpenLoop(whole.between()).closed()), True, ticks=16)
    assert verdict == "marginal"
    assert abs(poles[0].distance) < 1e-12


@pytest.mark.parametrize("seen", [False, True])
def test_a_neutral_mode_is_left_out_in_any_coordinates(seen: bool) -> None:
    """The response stays that of the loop before a mode at 1 was put beside it."""
    dice = np.random.default_rng(5)
    poles, b, c, d = np.array([0.9, 0.5, -0.3]), dice.normal(size=3), 0.1 * dice.normal(size=3), 0.2
    a = np.diag([1.0, *poles])
    if seen:
        b, c = np.append(0.0, b), np.append(dice.normal(), c)
        a[1:, 0] = dice.normal(size=3)
    else:
        b, c = np.append(dice.normal(), b), np.append(0.0, c)
        a[0, 1:] = dice.normal(size=3)
    turned, _ = np.linalg.qr(dice.normal(size=(4, 4)))
    loop = OpenLoops((turned @ a @ turned.T)[None], (turned @ b)[None], (c @ turned.T)[None], np.array([d]))
    mode = neutral_mode(loop)
    assert mode is not None
    assert mode.seen == seen
    without, once = mode.left_out(loop)
    assert once.all()
    w = np.array([[0.01, 0.4, 2.0]])
    expected = d + np.sum(c[1:] * b[1:] / (np.exp(1j * w.T) - poles), axis=1)
    assert responses(without, w)[0] == pytest.approx(expected, rel=1e-12)
    assert neutral_mode(without) is None
