"""Both hemispherical resonator gyroscopes of the gallery: a program of their own, and closed forms from averaging.

The program steps both modes by SciPy's matrix exponential, in the axes of the shell's damping and stiffness, and has
demodulators, loops and rotations in plain Python. The closed forms are derived here: of a mode X sin wt with slow X,

    m (x'' + w^2 x) = F cos wt  gives  X' = F / (2 m w).

So more damping by D along the modal angle s turns a pattern at g by g' = D / 2 sin 2(g - s), which is D / (2 n)
sin 2n(h - s / n) at the angle h = g / n on the shell.
"""

import cmath
import math
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from proofmass import margins, noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

HELD = read_graph(library_file("hemispherical_rebalance.toml"))
FREE = read_graph(library_file("hemispherical_whole_angle.toml"))
AXES = ("resonator.shell.x_axis", "resonator.shell.y_axis")
QUIET = {f"{axis}.{key}": 0.0 for axis in AXES for key in ("driver_noise", "amplifier_noise", "temperature")}
M, F, Q, K, AMPLITUDE, T = 0.524e-3, 5000.0, 5e6, 0.277, 0.5e-6, 25e-6
W, DECAY = 2.0 * math.pi * F, math.pi * F / Q  # rad/s, and 1/s of an amplitude
D, SPLIT = 0.01 * DECAY, 2.0 * math.pi * 5e-3
MORE, SOFTER = math.radians(22.5), math.radians(67.5)  # on the shell
FORCE, VOLTS = 100.0 * 2e-12 / 1e-4, 1e7  # N/V and V/m
SINC = float(np.sinc(1.0 / 8.0))
PER_VOLT = SINC * FORCE * VOLTS / (2.0 * M * W)  # growth of a signal's amplitude per second


def equations(rotation: float, split: float = SPLIT) -> np.ndarray:
    """Rates of (x, y, vx, vy); stiffness and damping from turned axes."""

    def turned(angle: float, along: float, across: float) -> np.ndarray:
        c, s = math.cos(2.0 * angle), math.sin(2.0 * angle)
        axes = np.array([[c, -s], [s, c]])
        return np.asarray(axes @ np.diag([along, across]) @ axes.T)

    stiffness = turned(SOFTER, W * W - W * split, W * W + W * split)
    damping = turned(MORE, 2.0 * DECAY + D, 2.0 * DECAY - D)
    gyroscopic = 4.0 * K * rotation * np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, -damping - gyroscopic]])


def stepped(rotation: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition over a tick, and entry of two forces."""
    b = np.vstack([np.zeros((2, 2)), np.eye(2) / M])
    whole = scipy.linalg.expm(np.block([[equations(rotation), b], [np.zeros((2, 6))]]) * T)
    return whole[:4, :4], whole[:4, 4:]


class Control:
    """Loops in each eighth tick: V as the velocity, and as the displacement, along both axes of the shell."""

    def __init__(self, pattern: float, holds: bool) -> None:
        self.pattern, self.holds = pattern, holds
        self.offset = self.drive = self.nulling = self.rate = 0.0

    def __call__(self, along: np.ndarray, across: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Take the components of both signals along sine and cosine, by Lynch's E, Q, R, S and L."""
        e, q = along @ along + across @ across, 2.0 * (along[0] * across[1] - along[1] * across[0])
        r, s = along[0] ** 2 + across[0] ** 2 - along[1] ** 2 - across[1] ** 2, 2.0 * (along.prod() + across.prod())
        lag = math.atan2(2.0 * along @ across, along @ along - across @ across) / 2.0
        long, short = (math.sqrt(e + q) + math.sqrt(e - q)) / 2.0, (math.sqrt(e + q) - math.sqrt(e - q)) / 2.0
        angle = math.atan2(s, r) / 2.0
        if along @ [math.cos(angle), math.sin(angle)] < 0.0:
            angle += math.pi if angle <= 0.0 else -math.pi
        w, slow = 2.0 * math.pi * 20.0, 8.0 * T
        self.offset += (w / 2.0) ** 2 / (2.0 * math.pi) * slow * lag
        self.drive += w * w / 8.0 / PER_VOLT * slow * (5.0 - long)
        self.nulling += w * w / 8.0 / PER_VOLT * slow * short
        drive, nulling = w / PER_VOLT * (5.0 - long) + self.drive, w / PER_VOLT * short + self.nulling
        held = 0.0
        if self.holds:
            fast, error = 2.0 * math.pi * 80.0, self.pattern - angle / 2.0
            self.rate += fast * fast / 8.0 * slow * error
            held = fast * error + self.rate
        self.angle, self.held, self.nulled = angle / 2.0, held, nulling
        u = np.array([math.cos(angle), math.sin(angle)])
        v = np.array([-u[1], u[0]])
        control = w / (2.0 * math.pi) * lag + self.offset
        return drive * u + 2.0 * held * 5.0 / PER_VOLT * v, nulling * v, control


def by_hand(ticks: int, rotation: Any, pattern: float, holds: bool) -> dict[str, list[float]]:
    """Angle on the shell, rate that holds it, and voltage that nulls the quadrature, in each eighth tick."""
    maps = {rate: stepped(rate) for rate in {rotation(n * T) for n in range(ticks)}}
    u = np.array([math.cos(2.0 * pattern), math.sin(2.0 * pattern)])
    state = np.concatenate([AMPLITUDE * u, np.zeros(2)])
    along, across = 5.0 * u, np.zeros(2)
    control, turns = Control(pattern, holds), 0.25
    velocity, displacement, moved, sums = np.zeros(2), np.zeros(2), 0.0, np.zeros((2, 2))
    rows: dict[str, list[float]] = {"angle": [], "rate": [], "quadrature": []}
    for n in range(ticks):
        if n % 8 == 0:
            velocity, displacement, moved = control(along, across)
            for name, value in (("angle", control.angle), ("rate", control.held / K), ("quadrature", control.nulled)):
                rows[name].append(value)
        phase, lead = 2.0 * math.pi * turns, 2.0 * math.pi * (turns + 1.0 / 16.0)
        sums += np.outer([math.sin(phase), math.cos(phase)], VOLTS * state[:2]) / 4.0
        volts = velocity * math.cos(lead) + displacement * math.sin(lead)
        a, b = maps[rotation(n * T)]
        state, turns = a @ state + b @ (FORCE * volts), (turns + (F + moved) * T) % 1.0
        if n % 8 == 7:
            (along, across), sums = sums, np.zeros((2, 2))
    return rows


@pytest.mark.exhaustive
def test_force_to_rebalance_against_the_program() -> None:
    """40 ms: a step of 50 deg/s after 10 ms, about a pattern at 12 degrees."""
    changes = QUIET | {"pattern_angle": math.radians(12.0), "rotation.amplitude": math.radians(50.0)}
    graph = HELD.with_parameters(changes | {"rotation.start_time": 0.01})
    result = simulate(graph, samples=1601, engine="compiled")
    expected = by_hand(1601, lambda t: math.radians(50.0) if t > 0.01 - 1e-9 else 0.0, math.radians(12.0), holds=True)
    assert result["rate.output"].values == pytest.approx(np.array(expected["rate"]), abs=1e-6)
    voltage = result["resonator.quadrature_voltage"].values
    assert voltage == pytest.approx(np.array(expected["quadrature"]), abs=1e-6)
    assert np.ptp(voltage) > 0.05


@pytest.mark.exhaustive
def test_whole_angle_against_the_program() -> None:
    """40 ms at 1000 deg/s from 10 ms on, past the angles where the modal angle jumps by a turn."""
    changes = QUIET | {"start_angle": math.radians(-88.0), "turn": math.radians(1000.0), "begin.start_time": 0.01}
    result = simulate(FREE.with_parameters(changes), samples=1601, engine="compiled")
    rate = math.radians(1000.0)
    expected = by_hand(1601, lambda t: rate if t > 0.01 - 1e-9 else 0.0, math.radians(-88.0), holds=False)
    angles = np.unwrap(np.array(expected["angle"]), period=math.pi)
    assert np.ptp(expected["angle"]) > 3.0
    heading = result["heading.output"].values
    assert heading - heading[0] == pytest.approx((angles[0] - angles) / K, abs=1e-7)
    assert heading[-1] - heading[0] == pytest.approx(0.03 * rate, rel=0.01)


def drifting(angle: float) -> float:
    """Rate of the pattern on the shell, by averaging."""
    return D / 4.0 * math.sin(4.0 * (angle - MORE))


def turned_in_a_second(angle: float) -> float:
    """Angle by which the wave on a shell of one stiffness turns without control, from both equations of motion."""
    a = equations(0.0, split=0.0)
    start = np.concatenate([np.array([math.cos(2.0 * angle), math.sin(2.0 * angle)]), np.zeros(2)])
    x = np.array([(scipy.linalg.expm(a * (1.0 + n / (16.0 * F))) @ start)[:2] for n in range(16)])
    around = np.linspace(-2e-5, 2e-5, 101)
    moves = x @ np.array([np.cos(2.0 * (angle + around)), np.sin(2.0 * (angle + around))])
    bent, slope, _ = np.polyfit(around / 2e-5, (moves**2).sum(axis=0) - (moves[:, 50] ** 2).sum(), 2)
    return float(-slope / (2.0 * bent) * 2e-5)


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("degrees", [0.0, 10.0, 30.0, 50.0, 80.0])
def test_drift_over_the_pattern_angle(degrees: float) -> None:
    """D / (2 n) sin 2n(h - s / n) on the shell, of averaging, of both equations without control, and of the graph."""
    angle = math.radians(degrees)
    graph = FREE.with_parameters(QUIET | {"start_angle": angle, "turn": 0.0})
    measured = simulate(graph, duration=0.5, engine="compiled").measures["drift"].value
    assert drifting(angle) == pytest.approx(turned_in_a_second(angle), rel=2e-4)
    assert measured == pytest.approx(drifting(angle), abs=1.5e-3 * D / 4.0)


def test_whole_angle_turns_by_the_angular_gain() -> None:
    """300 deg/s either way: the drift that the pattern meets goes out of the difference, to a part in 10^5."""
    graphs = [FREE.with_parameters(QUIET | {"turn": math.radians(turn)}) for turn in (300.0, -300.0)]
    ways = [simulate(graph, duration=1.5, engine="compiled").measures for graph in graphs]
    for way in ways:
        assert way["turned"].value == pytest.approx(-K * way["truly"].value, rel=1e-5)
    assert ways[0]["turned"].value - ways[1]["turned"].value == pytest.approx(-2.0 * K * math.radians(300.0), rel=3e-6)


@pytest.mark.exhaustive
@pytest.mark.parametrize("degrees", [0.0, 30.0])
def test_forces_that_hold_a_pattern(degrees: float) -> None:
    """The drift makes a bias of -drift / k; stiffness takes m w dw a sin 2(g - t) of a force to null its quadrature."""
    angle = math.radians(degrees)
    measures = simulate(HELD.with_parameters(QUIET | {"pattern_angle": angle}), engine="compiled").measures
    assert measures["bias"].value == pytest.approx(-drifting(angle) / K, abs=3e-3 * D / 4.0 / K)
    assert measures["scale_factor"].value == pytest.approx(1.0, abs=2e-6)
    force = M * W * SPLIT * AMPLITUDE * math.sin(4.0 * (angle - SOFTER))
    assert measures["quadrature"].value == pytest.approx(force / FORCE / SINC, rel=2e-3)


def test_a_case_that_stands_and_a_pattern_that_is_turned() -> None:
    """A carousel of 36 deg/s turns the pattern by that rate, and no drift is left in the mean over the shell."""
    changes = QUIET | {"turn": 0.0, "carousel.value": math.radians(36.0), "begin.start_time": 9.0}
    result = simulate(FREE.with_parameters(changes | {"resonator.shell.damping_mismatch": 0.0}), engine="compiled")
    heading = result["heading.output"].values
    slope = (heading[9000] - heading[1000]) / (8000 * 8 * T)
    assert slope == pytest.approx(-math.radians(36.0) / K, rel=1e-5)


@pytest.mark.exhaustive
def test_margins() -> None:
    """The pattern integrates: 3/8 of a command arrive in the average of its own period, by a mode without damping."""
    c, s, state, average = math.cos(W * T), math.sin(W * T), np.zeros(2), [0.0, 0.0]
    for n in range(16):
        phase = math.pi * (0.5 + n / 4.0)
        average[n // 8] += state[0] * math.sin(phase)
        force = math.cos(phase + math.pi / 8.0) if n < 8 else 0.0
        state = np.array([c * state[0] + s * state[1] + (1.0 - c) * force, c * state[1] - s * state[0] + s * force])
    part = average[0] / average[1]
    slow, fast = 8.0 * T, 2.0 * math.pi * 80.0
    grid = np.geomspace(10.0, 2499.0, 200_001)
    z = np.exp(2j * math.pi * grid * slow)
    response = (fast + fast * fast / 8.0 * slow * z / (z - 1.0)) * slow * (part / z + 1.0 / (z * (z - 1.0)))
    crossing = int(np.argmin(np.abs(np.abs(response) - 1.0)))
    turned = int(np.flatnonzero(np.diff(np.sign(response.imag)))[0])
    found = margins(HELD, "rate")
    assert part == pytest.approx(3.0 / 8.0)
    assert found.phase_margin == pytest.approx(math.pi + cmath.phase(response[crossing]), abs=1e-4)
    assert found.gain_margin == pytest.approx(-1.0 / response[turned].real, rel=1e-3)
    closed = np.abs(response / (1.0 + response))
    assert found.bandwidth == pytest.approx(grid[np.flatnonzero(closed < math.sqrt(0.5))[0]], rel=1e-4)


BOLTZMANN = 1.380649e-23


def random_walks() -> tuple[float, float]:
    """One-sided densities of the rate of the case, in rad/s/sqrt(Hz): of damping, and of drivers of 300 nV/sqrt(Hz).

    Damping of 2 m / T each mode has forces of 8 k Tk m / T, of which sines and cosines about w have twice as much; a
    modal angle moves by F / (2 m w a), and by n k of the angle of the case.
    """
    damping = math.sqrt(4.0 * BOLTZMANN * 298.15 * DECAY / M) / (W * AMPLITUDE) / (2.0 * K)
    drivers = math.sqrt(2.0) * 300e-9 * FORCE / (2.0 * M * W * AMPLITUDE) / (2.0 * K)
    return damping, drivers


@pytest.mark.exhaustive
def test_angle_random_walk_of_the_budget() -> None:
    """0.00024 deg/sqrt(h); Northrop Grumman's has 0.00025 (Trusov and others, IEEE Inertial Sensors, 2016)."""
    budget = noise(HELD, "rate.output")
    low = {source.block.rpartition(".")[2]: source.density[0] for source in budget.sources[::-1]}
    expected = random_walks()
    assert math.sqrt(low["damping"]) == pytest.approx(expected[0], rel=1e-4)
    assert math.sqrt(low["driver"]) == pytest.approx(expected[1], rel=1e-4)
    walk = math.degrees(math.hypot(*expected)) / math.sqrt(2.0) * 60.0
    assert walk == pytest.approx(0.00025, rel=0.1)


@pytest.mark.exhaustive
def test_budget_of_the_heading() -> None:
    """It walks by what turns the pattern, and amplifiers of 5 nV/sqrt(Hz) add white noise, at 5 V of amplitude."""
    budget = noise(FREE, "heading.output", at="0 s", band=(0.5, 2500.0))
    walk, white = math.hypot(*random_walks()), math.sqrt(2.0) * 5e-9 / 5.0 / (2.0 * K)
    expected = np.hypot(walk / (2.0 * math.pi * budget.frequencies), white)
    low = budget.frequencies < 10.0
    assert np.sqrt(budget.density)[low] == pytest.approx(expected[low], rel=5e-3)
    assert math.sqrt(budget.density[-1]) == pytest.approx(white, rel=1e-3)


def test_angle_random_walk_of_a_run() -> None:
    """800 steps of the heading in 2.5 ms, which scatter by 5 % of their size."""
    still = {f"{axis}.amplifier_noise": 0.0 for axis in AXES} | {"turn": 0.0}
    heading = simulate(FREE.with_parameters(still), seed=11, engine="compiled")["heading.output"].values
    steps = np.diff(heading[::100])[5:]
    assert steps.std() == pytest.approx(math.hypot(*random_walks()) * math.sqrt(0.02 / 2.0), rel=0.2)


def test_the_shell_is_that_of_rayleigh() -> None:
    """Mass, Bryan's factor and frequency of a hemisphere that bends without stretching (Theory of Sound, 1894, 235b).

    At the angle t from the pole a point moves along the meridian by u cos na, around by u sin na, u = sin t tan^n(t/2),
    and outwards by -(n + cos t) tan^n(t/2) cos na: no fibre of the shell gets longer. The strain energy per area is
    D (1 - v) (b^2 + c^2), D = E h^3 / (12 (1 - v^2)), with changes of curvature b and -b and of twist c, as large as b.
    """
    radius, thickness, young, poisson, density, n = 15e-3, 0.88e-3, 73e9, 0.17, 2203.0, 2

    def over(function: Any) -> float:
        return float(scipy.integrate.quad(lambda t: function(t) * math.sin(t), 1e-9, math.pi / 2.0)[0])

    def shape(t: float) -> tuple[float, float]:
        power = math.tan(t / 2.0) ** n
        return math.sin(t) * power, -(n + math.cos(t)) * power

    def off_the_axis(t: float) -> float:
        u, out = shape(t)
        return u * math.cos(t) + out * math.sin(t)

    moving = over(lambda t: 2.0 * shape(t)[0] ** 2 + shape(t)[1] ** 2)
    rim = shape(math.pi / 2.0)[1]
    mass = density * thickness * radius**2 * math.pi * moving / rim**2
    bend = n * (n * n - 1.0) / radius**2  # over sin^2 t, times tan^n(t / 2)
    bent = over(lambda t: 2.0 * (bend * math.tan(t / 2.0) ** n / math.sin(t) ** 2) ** 2)
    plate = young * thickness**3 / (12.0 * (1.0 - poisson**2))
    stiffness = 2.0 * plate * (1.0 - poisson) * radius**2 * math.pi * bent / rim**2
    assert mass == pytest.approx(M, rel=1e-3)
    assert math.sqrt(stiffness / mass) == pytest.approx(W, rel=5e-3)
    assert -2.0 * over(lambda t: off_the_axis(t) * shape(t)[0]) / moving / n == pytest.approx(K, rel=1e-3)
