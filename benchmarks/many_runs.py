"""Many short runs, of a thousand samples each, with a ledger on disk: `python benchmarks/many_runs.py [RUNS]`, 1e6.

What the study takes besides its compiled loop, and memory. The sensors are those of `monte_carlo.py`.
"""

import resource
import sys
import tempfile
import threading
import time
from typing import Any

from monte_carlo import workload

from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.targets.native_lanes import Lanes

SAMPLES = 1000


class TimedLanes(Lanes):
    """Lanes that note the processor's time in the loop."""

    seconds = 0.0

    def advance(self, last: int, stop: threading.Event | None = None) -> None:
        """As `Lanes`."""
        began = time.thread_time()
        super().advance(last, stop)
        TimedLanes.seconds += time.thread_time() - began


def main(runs: int) -> None:
    """Run, and print."""
    import proofmass.runner.run.side_by_side as side_by_side

    engine: Any = {"engine": "compiled", "threads": 1}
    run_study(workload(256, SAMPLES), **engine)  # compiles
    side_by_side.Lanes = TimedLanes  # type: ignore[misc]
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        result = run_study(workload(runs, SAMPLES), folder=folder, **engine)
        seconds = time.process_time() - began
    outside = seconds - TimedLanes.seconds
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{len(result.numbers):,} runs of {SAMPLES:,} samples: {seconds:.1f} s, {runs / seconds:,.0f} runs a second")
    print(f"{TimedLanes.seconds / runs / SAMPLES * 1e9:.2f} ns a run-sample in the loop")
    print(f"{outside / runs * 1e6:.2f} us a run outside of it, {outside / seconds:.1%} (limit 20 %)")
    print(f"{resident:.0f} MB resident at most (limit 1000)")


if __name__ == "__main__":
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**6)
