"""The command `run` when it is interrupted, or runs out of room: what it says, and that it goes on to the same bits."""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks import WhiteNoise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.checkpoint import FILE
from proofmass.runner.run.simulate import simulate
from tests.by_hand.little_disk import little_room


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", "proofmass", *map(str, arguments)]


needs_proc = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="reads /proc")


class TestTheCommand:
    def interrupted(self, *arguments: str | Path, number: int = signal.SIGINT) -> tuple[int, str, float]:
        """Exit code and messages of a run that is interrupted in its loop, and the seconds that it took to end."""
        process = subprocess.Popen(
            command("run", *arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        status = Path(f"/proc/{process.pid}/status")
        caught = 0
        while not caught and process.poll() is None:
            time.sleep(0.05)  # SIGTERM is caught while the loop runs
            caught = int(status.read_text().partition("SigCgt:")[2].split()[0], 16) >> (signal.SIGTERM - 1) & 1
        time.sleep(0.3)
        began = time.monotonic()
        process.send_signal(number)
        messages = process.communicate(timeout=20)[1]
        assert "Traceback" not in messages
        return process.returncode, messages, time.monotonic() - began

    @pytest.mark.exhaustive("15")
    @needs_proc
    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
    @pytest.mark.friendly(24, "a run ends within a second of the signal")
    def test_ends_within_a_second(self, number: int) -> None:
        graph = library_file("pn_self_test_minimal.toml")
        code, messages, seconds = self.interrupted(graph, "--samples", "1_000_000_000", number=number)
        assert code == 130, messages
        assert seconds < 1.0
        assert "interrupted after" in messages
        assert "with --out FOLDER a run can be resumed" in messages

    @pytest.mark.exhaustive
    @needs_proc
    @pytest.mark.friendly(25, "the same command ends with the same bits")
    def test_resumes_to_the_same_bits(self, tmp_path: Path) -> None:
        path = tmp_path / "graph.toml"
        path.write_text(
            'name = "noise"\nrate = "1 kHz"\nsamples = 200_000\nprobes = [{ signal = "noise.output", every = 10 }]\n'
            '[blocks.noise]\nkind = "WhiteNoise"\ndensity = 1.0\n'
        )
        options = ("--engine", "python", "--format", "csv", "--quiet")
        code, messages, _ = self.interrupted(path, *options, "--out", tmp_path / "one")
        assert code == 130, messages
        assert "the same command goes on from there" in messages
        assert (tmp_path / "one" / FILE).exists()
        resumed = command("run", path, *options, "--out", tmp_path / "one")
        done = subprocess.run(resumed, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert "continues the interrupted run" in done.stderr
        whole = command("run", path, *options, "--out", tmp_path / "two")
        subprocess.run(whole, capture_output=True, check=True)
        assert (tmp_path / "one" / "traces.csv").read_bytes() == (tmp_path / "two" / "traces.csv").read_bytes()
        assert not (tmp_path / "one" / FILE).exists()

    @pytest.mark.exhaustive
    def test_says_when_the_disk_is_full_and_goes_on_when_there_is_room(self, tmp_path: Path) -> None:
        path = tmp_path / "graph.toml"
        path.write_text(
            'name = "long"\nrate = "1 kHz"\nsamples = 400_000\nprobes = ["noise.output"]\n'
            '[blocks.noise]\nkind = "WhiteNoise"\ndensity = 1.0\n'
        )
        script = (
            "import sys; from proofmass.runner.run import simulate; simulate.IN_MEMORY = 1000;"
            "from proofmass.runner.command_line import main; sys.exit(main(sys.argv[1:]))"
        )
        arguments = [sys.executable, "-c", script, "run", str(path), "--out", str(tmp_path / "out"), "--quiet"]
        arguments += ["--engine", "compiled"]
        done = subprocess.run(arguments, capture_output=True, text=True, check=False, **little_room(1_000_000))
        assert done.returncode == 3, done.stderr
        assert f"cannot write or read {tmp_path / 'out' / 'noise.output.npy'}: File too large" in done.stderr
        assert "the same run goes on" in done.stderr
        assert "Traceback" not in done.stderr
        done = subprocess.run([*arguments, "--resume"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        [trace] = [np.load(file) for file in (tmp_path / "out").glob("*.npy")]
        graph = Graph(name="long", rate="1 kHz", blocks={"noise": WhiteNoise(density=1.0)}, probes=["noise.output"])
        assert np.array_equal(trace, simulate(graph, samples=400_000, engine="compiled")["noise.output"].values)

    @pytest.mark.exhaustive("netcdf", "parquet")
    @pytest.mark.parametrize("form", ["netcdf", "csv", "parquet"])
    def test_says_when_the_results_do_not_fit(self, form: str, tmp_path: Path) -> None:
        arguments = command(
            "run", library_file("recorded_motion.toml"), "--duration", "1 s", "--format", form, "--out", tmp_path
        )
        arguments += ["--engine", "python"]
        done = subprocess.run(arguments, capture_output=True, text=True, check=False, **little_room(20_000))
        assert done.returncode == 3, done.stderr
        assert "Traceback" not in done.stderr
        assert re.search(rf"cannot write or read {tmp_path}/[a-z]+\.[a-z]+: .*too large", done.stderr, re.IGNORECASE)
        assert not list(tmp_path.glob("traces*"))

    def test_says_when_the_folder_cannot_be_made(self, tmp_path: Path) -> None:
        (tmp_path / "file").write_text("")
        arguments = command("run", library_file("template.toml"), "--samples", "3", "--out", tmp_path / "file" / "out")
        done = subprocess.run(arguments, capture_output=True, text=True, check=False)
        assert done.returncode == 3
        assert f"cannot write or read {tmp_path / 'file' / 'out'}: Not a directory" in done.stderr
        assert "Traceback" not in done.stderr
