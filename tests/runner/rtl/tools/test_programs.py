"""Programs of others are found on the PATH and beside the running Python."""

import sys
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.rtl.tools.programs import found, need_program


def test_programs_beside_python_are_found_without_an_active_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    name = Path(sys.executable).name
    assert found("no-such-program", name) == str(Path(sys.executable).parent / name)


def test_what_is_missing_is_told_with_what_to_install() -> None:
    with pytest.raises(ModelError) as caught:
        need_program("no-such-program", purpose="does it", hint="pip install it")
    assert "no-such-program is not installed: it does it" in str(caught.value)
    assert "pip install it" in str(caught.value)
