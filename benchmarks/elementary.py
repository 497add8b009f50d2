"""The largest errors of the elementary functions: `python -m benchmarks.elementary [COUNT]`, 10^7 arguments each.

Long doubles of at least 64 bits find the arguments with the largest errors in every 2^18, mpmath measures the error.
"""

import sys
import time

from tests.by_hand.elementary import CASES, LONG_IS_LONGER, measured


def main() -> None:
    if not LONG_IS_LONGER:
        sys.exit("long doubles of this machine have no more bits than numbers")
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**7
    for name, case in CASES.items():
        begin = time.process_time()
        error, at = measured(case, count, seed=1)
        print(
            f"{name:24} {error:.4f} ulp at {', '.join(map(repr, at)):45} {time.process_time() - begin:5.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
