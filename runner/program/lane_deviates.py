"""Normal deviates of runs side by side: those near the middle in all lanes, and then the rest, gathered.

To the bit `normal_deviate` of each run. Lanes of a vector cannot branch: computed in each of them, the logarithm and
the root that one deviate in seven needs would take most of the time.
"""

from typing import Any

from proofmass.blocks.arithmetic.counter_random import (
    central_quantile,
    is_central,
    quantile_of_root,
    root_of_logarithm,
    uniform_deviate,
)


def normal_deviates(
    seed: int, runs: Any, stream: int, sample: int, uniforms: Any, far: Any, places: Any, found: Any
) -> None:
    """Fill `found` with a deviate for each of `runs`; the arrays between, of as many entries, are to work on."""
    lanes = len(runs)
    for lane in range(lanes):
        uniforms[lane] = uniform_deviate(seed, runs[lane], stream, sample)
    for lane in range(lanes):
        found[lane] = central_quantile(uniforms[lane] - 0.5)
    count = 0
    for lane in range(lanes):
        places[count] = lane
        count += 1 - is_central(uniforms[lane] - 0.5)
    whole = min((count + 7) // 8 * 8, lanes)  # as vectors have them: what is beyond the last repeats it
    for place in range(whole):
        far[place] = uniforms[places[min(place, count - 1)]]
    for place in range(whole):
        far[place] = root_of_logarithm(far[place])
    for place in range(whole):
        far[place] = quantile_of_root(far[place])
    for place in range(count):
        lane = places[place]
        found[lane] = -far[place] if uniforms[lane] < 0.5 else far[place]
