"""A table of different values in order, each with its count. Joined values have negative counts."""


def place_of(ordered: list[float], values: int, u: float) -> int:
    """Number of the first value that is not below `u`."""
    low, high = 0, values
    while low < high:
        middle = (low + high) >> 1
        if ordered[middle] < u:
            low = middle + 1
        else:
            high = middle
    return low


def take_in(values: int, value: list[float], count: list[int], fresh: list[float], fresh_count: list[int]) -> None:
    """Put the fresh values into the table, from its end."""
    i = values - 1
    for k in range(len(fresh) - 1, -1, -1):
        while i >= 0 and value[i] > fresh[k]:
            value[i + k + 1], count[i + k + 1] = value[i], count[i]
            i -= 1
        value[i + k + 1], count[i + k + 1] = fresh[k], fresh_count[k]


def join_neighbours(
    values: int, value: list[float], count: list[int], limit: float, part: float, samples: float
) -> int:
    """Join neighbours with few samples together, but neither end of the table; return how many values are left.

    They have room for `limit` max(r / (n p), (n - r) / (n (1 - p))) samples at rank r of n samples,
    p being the wanted part: least there, and most in the longer tail (Dunning and Ertl's merging
    digest, Software Impacts 7 (2021), with the room of Cormode, Korn, Muthukrishnan and Srivastava,
    ICDE 2005).
    """
    last, below = 0, 0.0
    for i in range(1, values):
        few, more = float(abs(count[last])), float(abs(count[i]))
        room = limit * max(below / part, (samples - below) / (1.0 - part)) / samples
        if last > 0 and i < values - 1 and few + more <= room:
            value[last] = value[last] + more / (few + more) * (value[i] - value[last])
            count[last] = -abs(count[last]) - abs(count[i])
        else:
            below += few
            last += 1
            value[last], count[last] = value[i], count[i]
    return last + 1
