"""Machine code made in little time for short runs: the bits of optimised code, and of that where it is there."""

from pathlib import Path

import pytest

from proofmass import read_graph, simulate
from proofmass.graphs.model.limits import LARGEST_RUN
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run.engines import make_engine
from proofmass.runner.run.estimates import is_short
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.machine_code import QUICK
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan, module_of

ACCELEROMETER = "library:closed_loop_accelerometer"
TICKS = 2_000


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder of compiled loops, in a process that has loaded none."""
    monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path))
    monkeypatch.setattr(machine_code, "_loaded", {})
    return tmp_path


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize(
    "name",
    [
        "closed_loop_accelerometer",
        "self_calibration_fixed",  # integers
        "sigma_delta_accelerometer",  # decisions
        "imu_3dof",
        "self_calibration_online",
        "chopped_accelerometer",
        "pn_self_test_minimal",  # correlators: vectors
    ],
)
def test_all_that_moves_has_the_bits_of_optimised_code(name: str) -> None:
    planned = plan(read_graph(f"library:{name}").changed(probes=()))
    written = write_tick(planned)
    loops = [machine_code.load(written.program, settings) for settings in (QUICK, module_of(written).settings)]
    runs = [CompiledLoop(planned, 7, 3, start(planned), CompiledPlan(planned, written, loop)) for loop in loops]
    assert all(run.advance(TICKS, ()) for run in runs)
    quick, optimised = (run.memory() for run in runs)
    assert repr(quick) == repr(optimised)


def test_a_short_run_is_compiled_in_little_time(cache: Path) -> None:
    planned = plan(read_graph(ACCELEROMETER))
    simulate(read_graph(ACCELEROMETER), samples=5, engine="compiled")
    (made,) = cache.glob("*.o")
    assert made.stem == module_of(write_tick(planned), quick=True).key
    assert made.stem != module_of(write_tick(planned)).key


def test_a_long_run_is_optimised_and_short_ones_take_what_it_leaves(cache: Path) -> None:
    planned = plan(read_graph(ACCELEROMETER))
    make_engine(planned, "compiled", 0, 0, start(planned), LARGEST_RUN)
    simulate(read_graph(ACCELEROMETER), samples=5, engine="compiled")
    (made,) = cache.glob("*.o")
    assert made.stem == module_of(write_tick(planned)).key


def test_how_long_short_is() -> None:
    """Optimising gains 23 ns a tick of this loop for 97 ms, measured: it pays from four million ticks on."""
    planned = plan(read_graph(ACCELEROMETER))
    assert is_short(planned, 500_000)
    assert not is_short(planned, 4_000_000)


def test_like_parts_of_a_plan_share_their_machine_code() -> None:
    """The axes of a sensor differ in numbers, and the groups of each are other ones of the whole."""
    whole = plan(read_graph("library:imu_3dof"))
    parts = [whole.part({f"{axis}.damping"}) for axis in "xyz"]
    assert len({solver.name for part in parts for solver in part.solvers}) > 3
    assert len({module_of(write_tick(part)).key for part in parts}) == 1
