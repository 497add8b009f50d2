"""The disk resonator gyroscope of the gallery: a program of its own, both states in closed form, what reversal takes.

The program steps the disk and its pickoffs by SciPy's matrix exponential, and has detectors, controllers, reversal and
means in plain Python. Where both modes stand still in their envelopes (Lynch, Vibratory gyro analysis by the method of
averaging, 1995), with the driven mode X and the other one nulled, the force on the other is that of

    m (kxy + j w (cxy + 2 n k W)) X on y while x is driven, m (kxy + j w (cxy - 2 n k W)) Y on x while y is driven.

The paper is of the honeycomb disk of the National University of Defense Technology (Microsystems & Nanoengineering
2025, s41378-025-01011-4): from -40 to 60 degrees Celsius reversal with a deflected mode took 595 parts of 596 away.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from proofmass import margins, noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Probe
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import run_study

GRAPH = read_graph(library_file("disk_resonator_gyroscope.toml"))
PROBED = replace(GRAPH, probes=(Probe("raw.output"), Probe("reversal.corrected")))
QUIET = {f"disk.{axis}_{what}": 0.0 for axis in "xy" for what in ("gas.temperature", "amplifier.density")}
TICK, SLOW = 1.0 / 40_000.0, 1.0 / 5000.0
F, W = 5000.0, 2.0 * math.pi * 5000.0
MASS, PUSH, GAIN, MOTION = 2e-6, 2.0 * 2e-12 * 20.0 / 10e-6, 0.5e6, 1e-6
TURNING = 4.0 * 0.4  # 2 n k
SCALE = PUSH * np.sinc(1.0 / 8.0) / (MASS * TURNING * W * MOTION)  # rad/s per volt
DEGREES_PER_HOUR = math.radians(1.0) / 3600.0
ROOM, COLD, WARM = 298.15, 233.15, 333.15
PLAIN = {
    "temperature": ROOM,
    "quality_difference": 1e-2,
    "damping_angle": math.radians(10.0),
    "diagonal_voltage": 5.037,
    "second_voltage": 5.499,
    "pinch": 1e-4,
    "skew": 2e-5,
    "x_corner": 5e5,
    "y_corner": 5e5,
    "x_gain": GAIN,
    "y_gain": GAIN,
}


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that grows or falls is zero, by bisection."""
    grows = function(low) < 0.0
    while low < (middle := (low + high) / 2.0) < high:
        low, high = (middle, high) if (function(middle) < 0.0) is grows else (low, middle)
    return low


class Disk:
    """Stiffness, damping and corners of a disk, all over the mass, from its values."""

    def __init__(self, **changed: float) -> None:
        p = PLAIN | changed
        above = p["temperature"] - ROOM
        warm, twice = 1.0 - 62e-6 * above, math.radians(-40.0)
        difference = W * 2.0 * math.pi * 2.0
        spring = 2.0 * 2e-12 / (10e-6**2 * MASS)
        diagonal, second = spring * p["diagonal_voltage"] ** 2 / 2.0, spring * p["second_voltage"] ** 2
        first = W * W + diagonal  # of the suspension: the springs along x + y bring x to 5 kHz
        self.kx = warm * first - diagonal
        self.ky = warm * (first + 2.0 * difference * math.cos(twice)) - diagonal - second
        self.kxy = -warm * difference * math.sin(twice) - diagonal
        decay = W / 2.0 / 1e5 * (p["temperature"] / ROOM) ** 2
        more = decay * p["quality_difference"]
        s = 2.0 * p["damping_angle"]
        self.cx, self.cy, self.cxy = 2 * decay + more * math.cos(s), 2 * decay - more * math.cos(s), more * math.sin(s)
        drift = 2.0 * math.pi * (1.0 - 2e-3 * above)
        self.corners = p["x_corner"] * drift, p["y_corner"] * drift
        self.gains = p["x_gain"], p["y_gain"]
        self.pinch, self.skew = p["pinch"], p["skew"]

    def system(self, rate: float) -> tuple[np.ndarray, np.ndarray]:
        """Transition of (x, vx, y, vy, pickoffs) and entry of both voltages over a tick."""
        turn, (px, py), (gx, gy) = TURNING * rate, self.corners, self.gains
        a = np.array([
            [0, 1, 0, 0, 0, 0],
            [-self.kx, -self.cx, -self.kxy, turn - self.cxy, 0, 0],
            [0, 0, 0, 1, 0, 0],
            [-self.kxy, -turn - self.cxy, -self.ky, -self.cy, 0, 0],
            [px * gx, 0, 0, 0, -px, 0],
            [0, 0, py * gy, 0, 0, -py],
        ])  # fmt: skip
        b = np.zeros((6, 2))
        b[1], b[3] = [1.0, self.pinch - self.skew], [self.pinch + self.skew, 1.0]
        whole = scipy.linalg.expm(np.block([[a, b * PUSH / MASS], [np.zeros((2, 8))]]) * TICK)
        return whole[:6, :6], whole[:6, 6:]

    def raw(self, rate: float, y_driven: bool) -> float:
        """What force to rebalance says in one of the states: phasors of the displacement's sine."""
        at, other = (1, 0) if y_driven else (0, 1)
        k, c = ((self.kx, self.cx), (self.ky, self.cy))[at]
        turn = -TURNING * rate if y_driven else TURNING * rate
        leaks = np.array([[1.0, self.pinch - self.skew], [self.pinch + self.skew, 1.0]])
        lead = math.pi / 8.0 + math.atan(F / 500e3)

        def voltages(w: float) -> np.ndarray:
            held = np.sinc(w * TICK / 2.0 / math.pi) * np.exp(1j * (lead - w * TICK / 2.0))
            motion = 0.5 * (1.0 + 1j * w / self.corners[at]) / self.gains[at]
            forces = np.zeros(2, dtype=complex)
            forces[at], forces[other] = k - w * w + 1j * w * c, self.kxy + 1j * w * (self.cxy + turn)
            return np.linalg.solve(leaks, forces * motion * MASS / PUSH) / held

        # the drive has a cosine alone
        w0 = math.sqrt(k)
        w = root(lambda w: float(voltages(w)[at].real), w0 - 20.0, w0 + 20.0)
        return float(SCALE * voltages(w)[other].imag)


def short(settling: float, averaging: float) -> dict[str, float]:
    return QUIET | {"reversal.settling": settling, "reversal.averaging": averaging}


def by_hand(ticks: int, settling: int, averaging: int, turned: int) -> Iterator[tuple[float, float]]:
    """Raw rate and rate without bias at the controllers' ticks; slots by their ticks; it turns from a tick on."""
    disk = Disk()
    still, turning = disk.system(0.0), disk.system(math.radians(1.0))
    lead = math.pi / 8.0 + math.atan(0.01)
    wn = 2.0 * math.pi * 60.0
    kp, ki = 2.0 * wn / math.pi, wn * wn / math.pi * SLOW
    state, mean, total, turns = np.zeros(6), np.zeros(4), np.zeros(4), 0.0
    integral = agc = in_rate = in_quadrature = r = q = drive = control = corrected = 0.0
    slot, place, sums, counts = 0, 0, [0.0, 0.0], [0, 0]
    x_driven, kept = True, 0.0  # half the sum of the last pair
    for n in range(ticks):
        phase = 2.0 * math.pi * turns
        if n % 8 == 0:
            x_driven = slot == 0
            control = kp * mean[1] + integral + ki * mean[1]
            integral += ki * mean[1]
            error = 0.5 - mean[0]
            more = agc + 800.0 * SLOW * error
            wanted = 10.0 * error + more
            drive = min(max(wanted, -1.0), 1.0)
            if not ((wanted > 1.0 and more > agc) or (wanted < -1.0 and more < agc)):
                agc = more
            in_rate -= 800.0 * SLOW * mean[2]
            in_quadrature += 800.0 * SLOW * mean[3]
            r, q = in_rate - 10.0 * mean[2], in_quadrature + 10.0 * mean[3]
            raw = SCALE * r
            if place == settling + averaging and slot == 1:
                kept = (sums[0] / counts[0] + sums[1] / counts[1]) / 2.0
            if settling <= place < settling + averaging:
                if place == settling:
                    sums[slot], counts[slot] = 0.0, 0
                corrected = (raw - kept) if x_driven else -(raw - kept)
                sums[slot] += raw
                counts[slot] += 1
            yield raw, corrected
            place, slot = (0, 1 - slot) if place == settling + averaging else (place + 1, slot)
        of_drive, of_sense = (state[4], state[5]) if x_driven else (state[5], state[4])
        sine, cosine = math.sin(phase), math.cos(phase)
        total += [of_drive * sine, of_drive * cosine, of_sense * sine, of_sense * cosine]
        if n % 8 == 7:
            mean, total = total / 4.0, np.zeros(4)
        pair = [drive * math.cos(phase + lead), r * math.cos(phase + lead) + q * math.sin(phase + lead)]
        transition, entry = turning if n >= turned else still
        state = transition @ state + entry @ (pair if x_driven else pair[::-1])
        turns += (F + control) * TICK
        turns -= round(turns)


@pytest.mark.exhaustive
def test_against_a_program_of_its_own() -> None:
    """Two pairs of slots of 20 and 20 ms; from 60 ms on it turns."""
    ticks = 6500
    changed = short(0.02, 0.02) | {"rotation.start_time": 0.06}
    result = simulate(PROBED.with_parameters(changed), samples=ticks, engine="compiled")
    raw, corrected = zip(*by_hand(ticks, 100, 100, 2400), strict=True)
    assert result["raw.output"].values == pytest.approx(raw, abs=1e-7 * max(map(abs, raw)))
    assert result["reversal.corrected"].values == pytest.approx(corrected, abs=1e-7 * max(map(abs, corrected)))


ERRORS: dict[str, dict[str, float]] = {
    "no skew": {"skew": 0.0},
    "pinched": {"pinch": 1e-2},
    "untuned, late": {"diagonal_voltage": 5.2, "x_corner": 3e5, "y_corner": 3e5},
    "unlike gains": {"x_gain": 1.02 * GAIN},
}
RATE = math.radians(1.0)


def found(**changed: float) -> list[float]:
    """Raw rates of both states at rest, then of both at a degree a second."""
    names = {name if name == "temperature" else f"disk.{name}": value for name, value in changed.items()}
    turning = PROBED.with_parameters(short(0.25, 0.2) | names | {"rotation.start_time": 0.9005})
    rows = np.asarray(simulate(turning, samples=72_201, engine="compiled")["raw.output"].values)
    return [float(rows[2251 * k + 1250 : 2251 * k + 2250].mean()) for k in range(4)]


def both_states(disk: Disk) -> list[float]:
    return [disk.raw(rate, y_driven) for rate in (0.0, RATE) for y_driven in (False, True)]


def halves(raw: list[float]) -> tuple[float, float]:
    return (raw[0] - raw[1]) / 2.0, (raw[0] + raw[1]) / 2.0


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.exhaustive) for name in ERRORS])
def test_both_states_in_closed_form(name: str) -> None:
    changed = ERRORS[name]
    assert found(**changed) == pytest.approx(both_states(Disk(**changed)), abs=0.02 * DEGREES_PER_HOUR, rel=2e-6)


def test_what_changes_its_sign_with_the_rate_and_what_does_not() -> None:
    """The equations of both states to first order: phases late by f, electrodes pinched by p and turned by s.

    Half the sum: (cxy - p (cx + cy) / 2) / 2 n k and kxy / w times the mean of both phases. Half the difference: the
    turned electrodes times the mean damping, kxy / w times half the difference of the phases, and the bias times half
    that of the gains.
    """
    changed = {"diagonal_voltage": 5.2, "x_corner": 4e5, "y_gain": 1.02 * GAIN, "pinch": 3e-3, "skew": 1e-3}
    disk, raw = Disk(**changed), found(**changed)
    late, quadrature = math.atan(F / 4e5) - math.atan(F / 5e5), disk.kxy / (TURNING * W)
    damping = (disk.cxy - 3e-3 * (disk.cx + disk.cy) / 2.0) / TURNING
    turned = -1e-3 * (disk.cx + disk.cy) / 2.0 / TURNING
    error, bias = halves(raw)
    assert bias == pytest.approx(damping + quadrature * late / 2.0, rel=0.03)
    assert error == pytest.approx(turned + quadrature * late / 2.0 + 0.01 * bias, rel=0.03)
    assert (raw[2] - raw[3]) / 2.0 - error == pytest.approx(RATE * 0.99, rel=1e-3)


def test_drift_over_temperature_falls_by_tens() -> None:
    """From -40 to 60 degrees Celsius; the paper's 595 with a deflected mode is the most that is known."""
    raw = [found(temperature=at) for at in (COLD, ROOM, WARM)]
    for values, at in zip(raw, (COLD, ROOM, WARM), strict=True):
        assert values == pytest.approx(both_states(Disk(temperature=at)), abs=0.2 * DEGREES_PER_HOUR, rel=2e-4)
    one_state = np.ptp([values[0] for values in raw]) / DEGREES_PER_HOUR
    errors, biases = zip(*map(halves, raw), strict=True)
    both = np.ptp(errors) / DEGREES_PER_HOUR
    assert one_state == pytest.approx(41.7, abs=1.0)
    assert 20.0 < one_state / both < 595.0
    assert np.ptp(biases) / DEGREES_PER_HOUR == pytest.approx(one_state, rel=0.05)


@pytest.mark.exhaustive
def test_every_disk_of_a_lot_in_closed_form() -> None:
    """Within three standard deviations of what noise makes of 1.5 s: 0.29 deg/h at a hertz."""
    result = run_study(read_study(library_file("disk_resonator_gyroscope.toml")), runs=6)
    for run in result.numbers.tolist():
        (drawn,) = result.study.drawn(run)
        changed = {name.removeprefix("disk."): value for name, value in drawn.items()}
        raw = both_states(Disk(**changed))
        assert result["without_reversal"][run, 0] == pytest.approx(raw[0], abs=DEGREES_PER_HOUR)
        assert result["with_reversal"][run, 0] == pytest.approx(halves(raw)[0], abs=0.7 * DEGREES_PER_HOUR)


@pytest.mark.exhaustive
def test_the_loop_that_rebalances() -> None:
    """An envelope behind what is held over 200 us, its mean over these, and a tick; a controller of two parts."""
    gain = 10.0 * PUSH * np.sinc(1.0 / 8.0) * GAIN / (2.0 * MASS * W)
    kept = math.exp(-math.pi * F / 1e5 * SLOW)

    def loop(frequency: float) -> complex:
        z = np.exp(2j * np.pi * frequency * SLOW)
        return complex((1.0 + 80.0 * SLOW * z / (z - 1.0)) * gain * SLOW * (1.0 / (z - kept) + 0.5) / z)

    crossover = root(lambda f: abs(loop(f)) - 1.0, 20.0, 200.0)
    wide = root(lambda f: abs(loop(f) / (1.0 + loop(f))) - math.sqrt(0.5), crossover, 500.0)
    answer = margins(GRAPH)
    assert answer.phase_margin is not None
    assert answer.verdict == "stable"
    assert answer.gain_crossovers[0] == pytest.approx(crossover, rel=0.01)
    assert answer.bandwidth == pytest.approx(wide, rel=0.01)
    phase = math.degrees(np.angle(-loop(crossover)))
    assert math.degrees(answer.phase_margin) == pytest.approx(phase, abs=0.5)


@pytest.mark.exhaustive
def test_noise_of_the_rate() -> None:
    """Gas and amplifier, doubled by the demodulation, over the envelope of the mode; sinc(1/8) of a held sine."""
    budget = noise(GRAPH, "raw.output", frequencies=[0.01])
    density = {source.block: math.sqrt(source.density[0]) for source in budget.sources}
    damping, force = 2.0 * MASS * Disk().cy / 2.0, MASS * TURNING * W * MOTION
    gas = math.sqrt(8.0 * 1.380649e-23 * ROOM * damping) / force
    assert density["disk.y_gas"] == pytest.approx(gas * np.sinc(1.0 / 8.0), rel=0.01)
    motion = math.sqrt(2.0) * 5e-9 / GAIN * abs(damping * W + 0.02j * math.pi * 2.0 * MASS * W)  # what would make it
    assert density["disk.y_amplifier"] == pytest.approx(motion / force, rel=0.01)
