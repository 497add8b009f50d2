"""Memory and time of a billion samples of the PN self-test: `python benchmarks/memory.py [SAMPLES]`."""

import resource
import sys

from proofmass import read_graph, simulate
from proofmass.graphs.files.library import library_file

GRAPH = library_file("pn_self_test_minimal.toml")


def main(samples: int) -> None:
    """Run, and print the largest resident memory of this process."""
    result = simulate(read_graph(GRAPH), samples=samples, engine="compiled")
    rows = len(result["correlator.impulse_response"].values)
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{samples:,} samples, {rows:,} vectors of 16 sums: {result.seconds:.1f} s")
    print(f"{resident:.0f} MB resident at most (limit 400)")


if __name__ == "__main__":
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**9)
