"""A long run with thinned rows stays small: nothing is kept per sample."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_file

GRAPH = library_file("pn_self_test_minimal.toml")
SAMPLES = 10**9 if os.environ.get("PROOFMASS_LONG") == "1" else 2 * 10**7
LIMIT = 400  # MB


@pytest.mark.skipif(sys.platform != "linux", reason="the peak is read from /proc")
@pytest.mark.parametrize("cache", ["cold", "warm"] if SAMPLES > 10**8 else ["warm"])
def test_resident_memory_of_a_long_run(cache: str, tmp_path: Path) -> None:
    # VmHWM is of the process alone; ru_maxrss would count the process that started it.
    script = (
        "import sys; from proofmass import read_graph, simulate;"
        "result = simulate(read_graph(sys.argv[1]), samples=int(sys.argv[2]), engine='compiled');"
        "peak = next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM'));"
        "print(len(result['correlator.impulse_response'].values), peak)"
    )
    environment = os.environ | ({"PROOFMASS_CACHE": str(tmp_path / "cache")} if cache == "cold" else {})

    def ran(samples: int) -> tuple[int, float]:
        command = [sys.executable, "-c", script, str(GRAPH), str(samples)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        rows, resident = map(int, done.stdout.split())
        return rows, resident / 1024

    if cache == "warm":
        ran(10)
    rows, resident = ran(SAMPLES)
    assert rows == -(-SAMPLES // 1023)
    assert resident < LIMIT
    if cache == "warm":
        few, least = ran(10)
        assert few == 1
        # what a long run needs beyond a short one: its rows, and those of a chunk
        assert resident - least < rows * 16 * 8 / 2**20 + 50
