"""Whole-process times of the command line, beside their limits: `python benchmarks/startup.py`.

Each command runs in a process of its own, five times; the least is shown, in seconds of the clock and of the processor.
"Cold" is an empty folder of compiled loops; bytecode of Python is kept, as after the first command of an installation.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in commands: before NumPy is loaded

from proofmass import margins, read_graph
from proofmass.graphs.files.library import library_file

CLOSED_LOOP = str(library_file("closed_loop_accelerometer.toml"))


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        chain = Path(folder) / "twenty_blocks.toml"
        chain.write_text(twenty_blocks())
        rows = [
            ("proofmass --help", ["--help"], False, 0.25),
            ("check, 20 blocks", ["check", str(chain)], False, 0.5),
            ("first 1,000 samples, cold", ["run", CLOSED_LOOP, "--samples", "1000"], True, 0.35),
            ("1,000,000 samples, cold", ["run", CLOSED_LOOP], True, 1.2),
            ("1,000,000 samples, warm", ["run", CLOSED_LOOP], False, 0.45),
        ]
        print(f"{'command':28} {'seconds':>8} {'limit':>6} {'CPU':>6}")
        for name, arguments, cold, limit in rows:
            _seconds(arguments, folder, cold)  # keeps bytecode, and the loop where it is to be warm
            clocks, processors = zip(*(_seconds(arguments, folder, cold) for _ in range(5)), strict=True)
            print(f"{name:28} {min(clocks):8.2f} {limit:6.2f} {min(processors):6.2f}")
        _margins(folder)


def _margins(folder: str) -> None:
    """Print processor times of margins: of a command until its figures stand there, and of one call of many."""
    first = min(_until_first_line(["margins", CLOSED_LOOP], folder) for _ in range(5))
    print(f"{'margins, until its figures':28} {'':8} {'':6} {first:6.2f}  CPU s, 0.60 wanted")
    graph, times = read_graph(CLOSED_LOOP), list[float]()
    for _ in range(8):
        began = time.process_time()
        margins(graph)
        times.append(time.process_time() - began)
    print(f"{'margins, a call, warm':28} {'':8} {'':6} {1e3 * min(times):6.1f}  CPU ms, 30 wanted")


def _until_first_line(arguments: list[str], folder: str) -> float:
    """Return the processor seconds of a command until it prints; of Linux, which tells those of a process that runs."""
    environment = os.environ | {"PROOFMASS_CACHE": f"{folder}/cache"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", "proofmass", *arguments]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        spent = Path(f"/proc/{process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[11:13]
        process.communicate()
    return sum(map(int, spent)) / os.sysconf("SC_CLK_TCK")


def twenty_blocks() -> str:
    """A source and nineteen gains in a row."""
    lines = ['name = "chain"', 'rate = "10 kHz"', "wires = ["]
    lines += [f'    "b{n}.output -> b{n + 1}.input",' for n in range(19)]
    lines += ["]", 'probes = ["b19.output"]', "[blocks.b0]", 'kind = "Sine"']
    for n in range(1, 20):
        lines += [f"[blocks.b{n}]", 'kind = "Gain"', f"gain = {n}"]
    return "\n".join(lines) + "\n"


def _seconds(arguments: list[str], folder: str, cold: bool) -> tuple[float, float]:
    """Seconds of the clock and of the processor."""
    with tempfile.TemporaryDirectory() as empty:
        cache = empty if cold else f"{folder}/cache"
        environment = os.environ | {"PROOFMASS_CACHE": cache, "PYTHONPYCACHEPREFIX": f"{folder}/bytecode"}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "proofmass", *arguments], env=environment, check=True, capture_output=True
        )
        ended, behind = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        return ended - began, behind.ru_utime + behind.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    main()
