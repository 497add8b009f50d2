"""A walk over all blocks: what must hold for each of them, now and when one is added."""

import ast
import inspect
import math
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks.declaration.catalog import all_blocks, facts, family_of, find
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.families import families, homes
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.contract.contract import STILL, check_block
from proofmass.runner.contract.declared import outside
from proofmass.runner.output.describe import block_text

ROOT = Path(__file__).parents[2]
KINDS = all_blocks()
every_block = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


def source_of(kind: type[Block]) -> Path:
    return Path(inspect.getfile(sys.modules[kind.__module__])).resolve()


def test_the_first_blocks_are_all_there() -> None:
    assert {
        "AnalogToDigital", "Chirp", "CombDrive", "Constant", "Correlator", "Decimator", "DigitalToAnalog",
        "DiscreteIntegrator", "DiscreteTransferFunction", "DisplacementReadout", "Gain", "LowPass",
        "MassSpringDamper", "OneBitActuator", "PID", "PiecewiseConstant", "Product", "Pulse", "Ramp", "RecordedSignal",
        "RunningRange", "RunningStatistics", "SampleAndHold", "Saturation", "ShiftRegister", "Sine", "Step", "Sum",
        "TransferFunction", "UnitDelay", "WhiteNoise",
    } <= set(KINDS)  # fmt: skip


def test_kinds_are_unique_over_all_families() -> None:
    stems = [stem.replace("_", "") for family in families().values() for stem in family]
    assert len(stems) == len(set(stems)) == len(homes())
    assert sorted(kind.lower() for kind in KINDS) == sorted(stems)


def test_blocks_are_imported_from_the_package_lazily() -> None:
    from proofmass import blocks

    assert blocks.Gain is KINDS["Gain"]
    assert "MassSpringDamper" in dir(blocks)
    with pytest.raises(ImportError, match="Gian"):
        from proofmass.blocks import Gian  # noqa: F401


@every_block
def test_one_block_one_file_one_test_file(kind: type[Block]) -> None:
    path = source_of(kind)
    assert path.parent == ROOT / "blocks" / family_of(kind)
    assert path.stem.replace("_", "") == kind.__name__.lower()
    assert find(kind.__name__) is kind
    test = ROOT / "tests" / "blocks" / family_of(kind) / f"test_{path.stem}.py"
    assert "def test_" in test.read_text(encoding="utf-8")
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 100


@pytest.mark.exhaustive("SpectrumMeter", "DecimatingFilter")
@every_block
def test_what_is_declared_keeps_the_contract_of_blocks(kind: type[Block]) -> None:
    assert [problem for check in STILL.values() for problem in check(kind).problems] == []
    assert "=" in facts(kind)["equation"] or ":" in facts(kind)["equation"]


@pytest.mark.exhaustive
@every_block
def test_every_block_keeps_the_contract_when_it_is_run(kind: type[Block]) -> None:
    report = check_block(kind)
    assert report.passed, report


@every_block
def test_text_for_people_names_every_fact(kind: type[Block]) -> None:
    text = block_text(kind)
    for name in (*kind.parameters, *kind.inputs, *kind.outputs, kind.__name__):
        assert name in text


@every_block
def test_functions_are_pure_and_use_the_standard_library_only(kind: type[Block]) -> None:
    tree = ast.parse(source_of(kind).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        modules: list[str] = []
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            modules = [node.module or ""]
        for module in modules:
            assert module.split(".")[0] in sys.stdlib_module_names or module.startswith("proofmass.blocks.")
        assert not isinstance(node, ast.Global | ast.Nonlocal | ast.Raise | ast.Try)
    for role in ("update", "derivative", *kind.outputs):
        behaviour = kind.output_functions.get(role) or kind.functions.get(role)
        if behaviour is not None:
            body = ast.parse(inspect.getsource(behaviour.function))
            powers = [n for n in ast.walk(body) if isinstance(n, ast.Pow)]
            assert not powers, "a power is a call to the library in one engine and products in the other"


BAD: list[Any] = [math.nan, math.inf, -math.inf, None, "no number", [], {}, 10**400, "1 furlong", object()]


@every_block
def test_bad_values_are_refused_with_key_and_value(kind: type[Block]) -> None:
    for name, parameter in kind.parameters.items():
        for bad in [*BAD, True if parameter.kind is not bool else 1]:
            if parameter.kind is str and isinstance(bad, str) and not parameter.choices and not _is_unit(name):
                continue
            with pytest.raises(ModelError) as caught:
                kind(**{name: bad})
            text = str(caught.value)
            assert f"{kind.__name__}.{name}" in text
            assert "got:" in text
            assert "expected:" in text


@every_block
def test_bounds_are_kept_on_both_sides(kind: type[Block]) -> None:
    for name, parameter in kind.parameters.items():
        for bound, value in outside(parameter).items():
            with pytest.raises(ModelError, match=re.escape(f"{kind.__name__}.{name}")) as caught:
                kind(**{name: value})
            assert f"{bound:g}" in str(caught.value)


@every_block
def test_a_misspelt_parameter_gets_the_right_name(kind: type[Block]) -> None:
    for name in kind.parameters:
        misspelt = name[:-1] + ("x" if name[-1] != "x" else "y")
        if len(name) < 4 or misspelt in kind.parameters:
            continue
        with pytest.raises(ModelError) as caught:
            kind(**{misspelt: 1.0})
        assert f"did you mean {name}?" in str(caught.value) or name in str(caught.value)


@every_block
def test_frozen_and_equal_by_value(kind: type[Block]) -> None:
    block = kind()
    assert block == kind()
    assert hash(block) == hash(kind())
    for name in kind.parameters:
        with pytest.raises(AttributeError):
            setattr(block, name, 1.0)
    assert repr(block).startswith(f"{kind.__name__}(")


def _is_unit(name: str) -> bool:
    return name == "unit" or name.endswith("_unit")
