"""The cache of compiled loops: never stale, never trusted when others could write to it; no fused arithmetic."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import pytest

from proofmass.blocks import Constant, Gain, Negation
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.host import cache as machine_code
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run.simulate import simulate
from proofmass.runner.targets import machine_code as compiler
from proofmass.runner.targets.llvm_text import llvm_text
from proofmass.runner.targets.machine_code import QUICK
from proofmass.runner.targets.native import module_of, settings

OWN = """
from typing import Any

from proofmass import Block, Input, param
from {helper} import FACTOR, helped

class Own(Block):
    \"\"\"A block of the user's own.\"\"\"
    gain: float = param("1", "Gain.", default=1.0)
    input = Input("1", "Input.")

@Own.output("1")
def output(p: Any, input: float) -> float:
    \"\"\"Output.\"\"\"
    return helped(p.gain * input) * FACTOR
"""
HELPER = "FACTOR = {factor}\n\ndef helped(x: float) -> float:\n    return x + {added}\n"
GRAPH = """
name = "own"
rate = "1 kHz"
samples = 5
wires = ["source.output -> mine.input"]
probes = ["mine.output"]
[blocks.source]
kind = "Constant"
value = 3.0
[blocks.mine]
kind = "Own"
"""


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder of the test's own, and a process that has loaded nothing."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("PROOFMASS_CACHE", str(folder))
    monkeypatch.setattr(compiler, "_loaded", {})
    return folder


def amplifier(gain: float = 2.0, block: Block | None = None) -> Graph:
    """A constant 3 through a block."""
    return Graph(
        name="amplifier",
        rate="1 kHz",
        blocks={"source": Constant(value=3.0), "amplifier": block or Gain(gain=gain)},
        wires=["source.output -> amplifier.input"],
        probes=["amplifier.output"],
    )


def answer(graph: Graph) -> float:
    """The last value that the compiled engine records."""
    result = simulate(graph, samples=5, engine="compiled")
    return float(next(iter(result.traces.values())).values[-1])


def key(graph: Graph) -> str:
    return module_of(write_tick(plan(graph)), quick=True).key


def forget() -> None:
    """As a fresh process would start."""
    compiler._loaded.clear()


def objects(folder: Path) -> dict[str, int]:
    """Object files and when each was written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("*.o")}


def run_own(folder: Path, cache: Path, *more: str) -> float:
    """The answer of the user's own block, computed by a fresh process."""
    script = (
        "import json, sys; from proofmass.runner.command_line import main; code = main(sys.argv[1:]);"
        "assert 'numba' not in sys.modules; sys.exit(code)"
    )
    command = [sys.executable, "-c", script, "run", "own.toml", "--blocks", "own.py", "--engine", "compiled", "--json"]
    environment = os.environ | {"PROOFMASS_CACHE": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    environment["PYTHONPATH"] = os.pathsep.join([str(folder), environment.get("PYTHONPATH", "")])
    done = subprocess.run([*command, *more], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = re.search(r'"last": ([-\d.e]+)', done.stdout)
    assert found
    return float(found[1])


def write_own(folder: Path, factor: float, added: float = 0.0) -> None:
    (folder / "own_helper.py").write_text(HELPER.format(factor=factor, added=added))
    (folder / "own.py").write_text(OWN.format(helper="own_helper"))
    (folder / "own.toml").write_text(GRAPH)


def test_changing_a_parameter_compiles_nothing(cache: Path) -> None:
    assert answer(amplifier(2.0)) == 6.0
    before = objects(cache)
    assert len(before) == 1
    forget()
    assert answer(amplifier(5.0)) == 15.0
    assert objects(cache) == before
    assert key(amplifier(2.0)) == key(amplifier(5.0))


def test_another_graph_or_block_has_another_key() -> None:
    wired = amplifier()
    assert len({key(wired), key(amplifier(block=Negation()))}) == 2


@pytest.mark.exhaustive
def test_editing_a_users_block_or_what_it_imports_gives_the_new_answer(tmp_path: Path, cache: Path) -> None:
    write_own(tmp_path, factor=2.0)
    assert run_own(tmp_path, cache) == 6.0
    first = objects(cache)
    # touched, and a comment more: the same code
    write_own(tmp_path, factor=2.0)
    (tmp_path / "own.py").write_text("# a comment\n" + OWN.format(helper="own_helper"))
    assert run_own(tmp_path, cache) == 6.0
    assert objects(cache) == first
    # a constant of another module that the block imports
    write_own(tmp_path, factor=7.0)
    assert run_own(tmp_path, cache) == 21.0
    # a function of another module
    write_own(tmp_path, factor=7.0, added=1.0)
    assert run_own(tmp_path, cache) == 28.0
    assert len(objects(cache)) == 3
    # and back: a hit
    before = objects(cache)
    write_own(tmp_path, factor=2.0)
    assert run_own(tmp_path, cache) == 6.0
    assert objects(cache) == before


def test_a_file_edited_after_its_import_leaves_nothing_stale(
    tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)

    def loaded(factor: float, name: str) -> type[Block]:
        (tmp_path / f"{name}.py").write_text(HELPER.format(factor=factor, added=0.0))
        (tmp_path / "late.py").write_text(OWN.format(helper=name))
        return load_own_blocks(tmp_path / "late.py")["Own"]

    old = loaded(2.0, "late_helper")
    (tmp_path / "late.py").write_text(OWN.format(helper="late_helper").replace("* FACTOR", "* FACTOR * 10.0"))
    assert answer(amplifier(block=old())) == 6.0
    new = load_own_blocks(tmp_path / "late.py")["Own"]
    forget()
    assert answer(amplifier(block=new())) == 60.0


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:20],
        lambda data: data[: len(data) // 2],
        lambda data: data[:100] + bytes([data[100] ^ 1]) + data[101:],
        lambda data: b"\0" * len(data),
        lambda data: data + b"more",
    ],
    ids=["empty", "in the digest", "half", "one bit", "zeros", "longer"],
)
def test_a_damaged_file_is_compiled_again(cache: Path, damage: Any) -> None:
    assert answer(amplifier()) == 6.0
    [path] = cache.glob("*.o")
    path.write_bytes(damage(path.read_bytes()))
    forget()
    assert not compiler.is_cached(path.stem)
    assert answer(amplifier()) == 6.0
    forget()
    assert compiler.is_cached(path.stem)


class TestAFolderThatOthersCouldWriteTo:
    """Another loop under the right name and with a right digest: only the folder's mode and owner can tell."""

    @pytest.fixture
    def forged(self, cache: Path) -> Path:
        assert answer(amplifier()) == 6.0
        right = key(amplifier())
        assert answer(amplifier(block=Tripled())) == 9.0
        shutil.copy(cache / f"{key(amplifier(block=Tripled()))}.o", cache / f"{right}.o")
        forget()
        return cache

    def test_the_forgery_would_work(self, forged: Path) -> None:
        assert answer(amplifier()) == 9.0

    @pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o1777])
    def test_it_is_not_read_when_writable(self, forged: Path, mode: int) -> None:
        forged.chmod(mode)
        assert answer(amplifier()) == 6.0

    @pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners are of POSIX")
    def test_it_is_not_read_when_of_another_owner(self, forged: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        owner = os.getuid()
        monkeypatch.setattr(os, "getuid", lambda: owner + 1)
        assert answer(amplifier()) == 6.0


class Tripled(Block):
    """Thrice the input, with a parameter that does nothing."""

    gain: float = param("1", "Nothing.", default=1.0)
    input = Input("1", "Input.")


@Tripled.output("1")
def output(p: Any, input: float) -> float:
    """Thrice the input."""
    return 3.0 * input


def test_the_folder_is_made_for_the_user_alone(cache: Path) -> None:
    answer(amplifier())
    assert cache.stat().st_mode & 0o777 == 0o700
    [path] = cache.glob("*.o")
    data = path.read_bytes()
    assert data[:32] == hashlib.sha256(data[32:]).digest()


def test_a_folder_that_cannot_be_written_is_no_error(
    tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path / "file" / "cache"))
    assert answer(amplifier()) == 6.0
    monkeypatch.setenv("PROOFMASS_CACHE", str(cache))

    def full(*arguments: Any, **more: Any) -> Any:
        raise OSError(28, "No space left on device")

    forget()
    monkeypatch.setattr(machine_code.tempfile, "mkstemp", full)  # type: ignore[attr-defined]
    assert answer(amplifier()) == 6.0
    assert not objects(cache)


@pytest.mark.exhaustive
def test_two_processes_at_once_and_a_warm_one(tmp_path: Path, cache: Path) -> None:
    script = (
        "import sys; from proofmass import read_graph, simulate;"
        "values = simulate(read_graph(sys.argv[1]), samples=3000, engine='compiled')['dac.code'].values;"
        "import hashlib; print(hashlib.sha256(values.tobytes()).hexdigest(), 'numba' in sys.modules)"
    )
    command = [sys.executable, "-c", script, str(library_file("closed_loop_accelerometer.toml"))]
    environment = os.environ | {"PROOFMASS_CACHE": str(cache)}

    def started() -> "subprocess.Popen[str]":
        return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)

    at_once = [started(), started()]
    cold = [process.communicate()[0].split() for process in at_once]
    assert [numba for _, numba in cold] == ["False", "False"]
    assert len(objects(cache)) == 1
    assert not list(cache.glob("tmp*"))
    warm = started().communicate()[0].split()
    assert warm == [cold[0][0], "False"]
    assert cold[0][0] == cold[1][0]


@pytest.mark.parametrize(
    "statement", ["import proofmass", "from proofmass.runner.command_line import main; main(['--help'])"]
)
def test_nothing_heavy_is_imported_before_it_is_needed(statement: str) -> None:
    heavy = "{'numpy', 'numba', 'llvmlite', 'control', 'scipy', 'networkx', 'xarray', 'matplotlib', 'pyarrow'}"
    script = f"{statement}; import sys; sys.exit(','.join({heavy} & set(sys.modules)) or None)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not shutil.which("objdump"), reason="needs objdump")
@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("name", ["closed_loop_accelerometer", "pn_self_test_minimal", "recorded_motion"])
def test_no_fused_multiply_add_and_no_vector_library(name: str, quick: bool, tmp_path: Path) -> None:
    if not {"fma", "neon"} & {n for n, has in llvm.get_host_cpu_features().items() if has}:
        pytest.skip("this processor could not fuse")
    planned = plan(read_graph(library_file(f"{name}.toml")))
    written = write_tick(planned)
    told = QUICK if quick else settings(written)
    (tmp_path / "loop.o").write_bytes(compiler.object_code(llvm_text(written.program), told))
    text = subprocess.run(
        ["objdump", "-dt", str(tmp_path / "loop.o")], capture_output=True, text=True, check=True
    ).stdout
    assert re.search(r"\b(v?mulsd|fmul)\b", text), "a loop without a multiplication is not this one"
    assert not re.search(r"\b(v?fn?m(add|sub)|fmla|fmls)", text)
    called = set(re.findall(r"\*UND\*\s+\S+\s+(\S+)", text))
    assert not {symbol for symbol in called if "svml" in symbol or symbol.startswith(("_ZGV", "amd_"))}, called


def test_what_cannot_be_compiled_is_named(tmp_path: Path) -> None:
    path = tmp_path / "strange.py"
    text = OWN.format(helper="math").replace("FACTOR, helped", "tau")
    path.write_text(text.replace("helped(p.gain * input) * FACTOR", "float.fromhex(input.hex())"))
    graph = amplifier(block=load_own_blocks(path)["Own"]())
    for engine in ("python", "compiled"):
        with pytest.raises(ModelError, match=r"float\.fromhex is not compiled") as caught:
            simulate(graph, samples=5, engine=engine)  # type: ignore[arg-type]
        [problem] = caught.value.problems
        assert problem.file.endswith("strange.py")
        assert problem.line == 15


def test_two_kinds_of_the_same_name_are_kept_apart() -> None:
    def kind(factor: float) -> type[Block]:
        class Same(Block):
            """A block."""

            input = Input("1", "Input.")

        @Same.output("1")
        def output(p: Any, input: float) -> float:
            """Output."""
            return factor * input

        return Same

    graph = Graph(
        name="same",
        rate="1 kHz",
        blocks={"source": Constant(value=1.0), "double": kind(2.0)(), "triple": kind(3.0)()},
        wires=["source.output -> double.input", "source.output -> triple.input"],
        probes=["double.output", "triple.output"],
    )
    for engine in ("python", "compiled"):
        result = simulate(graph, samples=3, engine=engine)
        assert [result["double.output"].values[-1], result["triple.output"].values[-1]] == [2.0, 3.0]
