"""Each graph of the library has the same bits as machine code, as C and as WebAssembly, and can be written as PTX."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.form import Program, Storage, Value
from proofmass.runner.program.listing import listing
from proofmass.runner.targets.gpu import ptx_text
from proofmass.runner.targets.lane_text import LanesOf
from proofmass.runner.targets.llvm_functions import externals
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
from proofmass.runner.targets.wasm import wasm_module
from tests.by_hand.gcc import compiled_by_gcc, needs_gcc, run_in_c
from tests.by_hand.graph_texts import ALONE, OF_SAME_PARTS
from tests.by_hand.node import needs_node, run_in_node
from tests.by_hand.ptxas import assembled, needs_ptxas
from tests.by_hand.verify_program import verify

TICKS = 500
SEED, RUN = 5, 2
GRAPHS = [
    pytest.param(path.name, id=path.name, marks=pytest.mark.exhaustive if path.stem in OF_SAME_PARTS else ())
    for path in ALONE
]


@pytest.fixture(scope="module")
def plans() -> dict[str, CompiledPlan]:
    """Plans that have been compiled."""
    return {}


def compiled(name: str, plans: dict[str, CompiledPlan]) -> CompiledPlan:
    if name not in plans:
        plans[name] = CompiledPlan(plan(read_graph(library_files()[name])))
    return plans[name]


def rows(planned: Plan) -> list[Any]:
    """Room for what the probes record."""
    kinds = {float: np.float64, int: np.int64, bool: np.bool_}
    return [np.zeros((max(p.rows(0, TICKS), 1), *p.shape), dtype=kinds[p.dtype]) for p in planned.probes]


def begun(made: CompiledPlan) -> list[Any]:
    """Arrays of a run before its first tick."""
    loop = CompiledLoop(made.plan, SEED, RUN, start(made.plan), made)
    arrays = loop.arrays(rows(made.plan))
    for array in arrays[4:5]:
        array.fill(np.nan)  # scratch, as the engine has it
    return arrays


def behind(made: CompiledPlan) -> list[Any]:
    """Arrays of the run behind its ticks, by machine code."""
    arrays = begun(made)
    made.loop(0, TICKS, SEED, RUN, *(array.ctypes.data for array in arrays))
    return arrays


def same(arrays: list[Any], others: list[Any]) -> bool:
    """Whether all arrays have the same bits; of NaN one is as good as another."""
    for one, other in zip(arrays, others, strict=True):
        if one.dtype == np.float64:
            nothing = np.isnan(one) & np.isnan(other)
            if not ((one.view(np.int64) == other.view(np.int64)) | nothing).all():
                return False
        elif not (one == other).all():
            return False
    return True


@pytest.mark.exhaustive(but=10)
@pytest.mark.exhaustive("quartz_calibration_disturbed.toml")
@pytest.mark.parametrize("name", GRAPHS)
def test_programs_keep_to_the_form_and_can_be_listed(name: str, plans: dict[str, CompiledPlan]) -> None:
    program = compiled(name, plans).written.program
    verify(program)
    assert "def loop(first: i64, last: i64, seed: i64, run: i64" in listing(program)


@pytest.mark.exhaustive(but=3)
@needs_gcc
@pytest.mark.parametrize("name", GRAPHS)
def test_c_has_the_bits_of_machine_code(name: str, plans: dict[str, CompiledPlan], tmp_path: Path) -> None:
    made = compiled(name, plans)
    arrays = begun(made)
    run_in_c(compiled_by_gcc(made.written.program, tmp_path), arrays, 0, TICKS, SEED, RUN)
    assert same(arrays, behind(made))


@pytest.mark.exhaustive(but=5)
@needs_node
@pytest.mark.parametrize("name", GRAPHS)
def test_webassembly_has_the_bits_of_machine_code(name: str, plans: dict[str, CompiledPlan], tmp_path: Path) -> None:
    made = compiled(name, plans)
    arrays, module = begun(made), wasm_module(made.written.program)
    run_in_node(module, [0, TICKS, SEED, RUN], arrays, tmp_path)
    if module.libm:
        pytest.skip(f"functions of another libm: {', '.join(module.libm)}")
    assert same(arrays, behind(made))


def runs_of(made: CompiledPlan) -> tuple[Program, LanesOf]:
    """The program of a plan, and what is another for each run."""
    program, planned = made.written.program, made.plan
    run = next(p for p in program.entry.parameters if isinstance(p, Value) and p.name == "run")
    recorded = {f"{block}__{port}" for block, port in planned.recorded}
    shared = frozenset(p for p in program.entry.parameters if isinstance(p, Storage) and p.name in recorded)
    return program, LanesOf(frozenset({run}), shared, {})


@needs_ptxas
@pytest.mark.exhaustive
@pytest.mark.parametrize("name", GRAPHS)
def test_ptx_can_be_assembled(name: str, plans: dict[str, CompiledPlan], tmp_path: Path) -> None:
    program, of_entry = runs_of(compiled(name, plans))
    if not externals(program):
        assert assembled(ptx_text(program, of_entry), tmp_path).startswith(b"\x7fELF")


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("name", GRAPHS)
def test_ptx_can_be_written(name: str, plans: dict[str, CompiledPlan]) -> None:
    program, of_entry = runs_of(compiled(name, plans))
    called = {external.symbol for external in externals(program).values()}
    if called:
        with pytest.raises(ModelError, match=f"a GPU has no function {sorted(called)[0]}"):
            ptx_text(program, of_entry)
    else:
        assert ".entry" in ptx_text(program, of_entry)
