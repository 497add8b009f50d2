"""Machine code of a course: written once, also of a part, whose runs are those of the whole."""

from dataclasses import replace

import numpy as np
import pytest

from proofmass import read_graph
from proofmass.runner.analysis.linearisation.forward import Course, MachineCode
from proofmass.runner.plan.keys import WireOf
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.program import tick
from proofmass.runner.run import engines


def test_a_plan_is_written_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """To see whether it was compiled before, and to run it."""
    planned = plan(read_graph("library:template"))
    monkeypatch.setattr(engines, "_spent", {})
    written, write = [], tick.write_tick
    monkeypatch.setattr(tick, "write_tick", lambda *of: written.append(of) or write(*of))
    code = MachineCode(planned)
    assert code.pays(100_000)
    code.run(planned, start(planned), 10)
    assert code.pays(1)
    code.run(planned, start(planned), 10)
    assert len(written) == 1


@pytest.mark.exhaustive
def test_slopes_have_the_code_of_the_lesser_part() -> None:
    """Each axis its own, which what is less shares; all three have that of the whole."""
    planned = plan(read_graph("library:imu_3dof"))
    course = Course(planned)
    first, again, other = (course.slopes(1_000, True, {name}) for name in ("x.damping", "x.adc", "y.damping"))
    assert first is again
    assert first is not None
    assert other is not None
    assert first.blocks.keys() != other.blocks.keys()
    assert first.of(planned).blocks.keys() == first.blocks.keys() < planned.blocks.keys()
    whole = course.slopes(1_000, True)
    assert whole is not None
    assert whole.of(planned) is planned


def test_sources_alone_say_what_they_say_in_the_whole() -> None:
    planned = plan(read_graph("library:chopped_accelerometer"))
    course, alone = Course(planned), {"excitation", "phases", "acceleration"}
    nodes = [(name, port) for name in sorted(alone) for port in type(planned.blocks[name]).outputs]
    part = course.part_in_code(course.at(0), 1_000_000, alone, nodes)
    whole = course.machine_code(course.at(0), 1_000_000)
    assert part is not None
    assert whole is not None
    said = part.wires(nodes, 3_000)
    assert np.ptp(said, axis=0).any()
    np.testing.assert_array_equal(said, whole.numbers([WireOf(*node) for node in nodes], 3_000))


def test_code_of_short_runs_is_optimised_for_a_long_one() -> None:
    """The bits stay, and runs that follow have the better code."""
    planned = replace(plan(read_graph("library:chopped_accelerometer")), probes=())
    code = MachineCode(planned)
    runs = [code.run(planned, start(planned), ticks) for ticks in (1_000, 1_000_000)]
    assert code.is_outgrown(1_000_000) is False
    assert all(run.advance(2_000, ()) for run in runs)
    first, second = (repr(run.memory()) for run in runs)
    assert first == second
