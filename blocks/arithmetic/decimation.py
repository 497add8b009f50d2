"""A filter of taps h that gives one value in some ticks: each input goes into the sums of the outputs to come.

Polyphase form: in phase p of the period the input has the tap h[(i + 1) ratio - 1 - p] in sum i
(Oppenheim and Schafer, Discrete-Time Signal Processing, section 4.7).
"""


def accumulate(sums: list[float], taps: list[float], ratio: int, tick: int, value: float) -> None:
    """Add an input to the sums, the nearest output first; they move up by one a period."""
    phase = tick % ratio
    if phase == 0:
        for i in range(len(sums) - 1):
            sums[i] = sums[i + 1]
        sums[len(sums) - 1] = 0.0
    for i in range(len(sums)):
        sums[i] = sums[i] + taps[(i + 1) * ratio - 1 - phase] * value
