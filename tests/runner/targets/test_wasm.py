"""Programs as WebAssembly modules: Node computes the bits of machine code with them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from proofmass.runner.targets import machine_code
from proofmass.runner.targets.wasm import wasm_module
from tests.by_hand.hostile_operations import operations_arrays, operations_program, operations_wrong
from tests.by_hand.node import needs_node, run_in_node
from tests.by_hand.random_programs import RandomProgram, random_arrays
from tests.by_hand.small_programs import SMALL, Case, of_libm


@needs_node
@pytest.mark.parametrize("constant", [None, 0, 1])
def test_operations_on_hostile_values(constant: int | None, tmp_path: Path) -> None:
    arrays = operations_arrays()
    run_in_node(wasm_module(operations_program(constant)), [], arrays, tmp_path)
    assert not operations_wrong(arrays, constant)


@needs_node
@pytest.mark.parametrize("case", SMALL.values())
def test_statements(case: Callable[[], Case], tmp_path: Path) -> None:
    made, before, behind = case()
    run_in_node(wasm_module(made), [], before, tmp_path)
    for array, expected in zip(before, behind, strict=True):
        assert array.tobytes() == expected.tobytes(), (array, expected)


@needs_node
@pytest.mark.parametrize("seed", range(20))
def test_random_programs_have_the_bits_of_machine_code(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path))
    made, arrays, others = RandomProgram(seed).program, random_arrays(seed), random_arrays(seed)
    run_in_node(wasm_module(made), [3], arrays, tmp_path)
    machine_code.load(made)(3, *(array.ctypes.data for array in others))
    for one, other in zip(arrays, others, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_module_says_what_it_wants() -> None:
    assert wasm_module(of_libm()[0]).libm == ("proofmass_exp", "proofmass_pow", "proofmass_sin")
    assert not wasm_module(SMALL["primes"]()[0]).libm


@needs_node
def test_functions_of_the_host_are_called(tmp_path: Path) -> None:
    made, before, behind = of_libm()
    run_in_node(wasm_module(made), [], before, tmp_path)
    np.testing.assert_allclose(before[0], behind[0], rtol=1e-15)
