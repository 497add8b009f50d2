"""Completion of commands, graphs, parameters, outputs, kinds and codes, as a shell gets it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from proofmass.runner.command_line import cli

FOLDER = Path(sys.executable).parent
BASH = """
PATH="$1:$PATH"
eval "$(_PROOFMASS_COMPLETE=bash_source proofmass)"
shift
for line in "$@"; do
    COMP_LINE="$line" COMP_POINT=${#line} COMP_WORDS=($line) COMP_CWORD=1 COMPREPLY=()
    _proofmass_completion proofmass
    printf '<%s>' "${COMPREPLY[@]}"
    echo
done
"""


def completions(*words: str) -> list[str]:
    """What may stand for the last word."""
    complete = ShellComplete(cli, {}, "proofmass", "_PROOFMASS_COMPLETE")
    return [item.value for item in complete.get_completions(list(words[:-1]), words[-1])]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("mar",), ["margins"]),
        (("run", "library:pn_self_test_m"), ["library:pn_self_test_minimal"]),
        (("run", "library:template", "--set", "adc.re"), ["adc.reference="]),
        (("run", "--set", "adc.re"), []),  # the graph comes later: nothing is known
        (("run", "library:template", "--probe", "sensor.d"), ["sensor.displacement"]),
        (("noise", "library:template", "--output", "ADC.C"), ["adc.code"]),
        (("margins", "no_such_file.toml", "--set", "adc."), []),
        (("blocks", "massspring"), ["MassSpringDamper"]),
        (("new", "x.toml", "--from", "closed_loop_g"), ["closed_loop_gyroscope"]),
        (("explain", "p0301"), ["P0301"]),
    ],
)
@pytest.mark.friendly(42, "words are completed")
def test_words(words: tuple[str, ...], expected: list[str]) -> None:
    assert completions(*words) == expected


def test_files_and_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sensors").mkdir()
    for name in ("sensor.toml", "sensor.csv", ".sensor.toml", "sensors/one.toml"):
        (tmp_path / name).write_text("", encoding="utf-8")
    assert completions("run", "") == ["sensor.toml", "sensors/"]
    assert completions("run", "sensors/") == ["sensors/one.toml"]
    assert completions("run", "nowhere/") == []


@pytest.mark.exhaustive
@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_takes_words_apart_at_colons_and_equals_signs() -> None:
    lines = ("proofmass run library:pn_self_test_m", "proofmass run library:template --set=adc.b", "proofmass ru")
    run = subprocess.run(["bash", "-c", BASH, "-", FOLDER, *lines], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == ["<pn_self_test_minimal >", "<adc.bits=>", "<run >"]
