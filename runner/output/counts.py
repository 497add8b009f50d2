"""Numbers with their nouns."""


def count(number: int, noun: str) -> str:
    """Return a number with its noun.

    >>> count(1, "problem"), count(2000, "tick")
    ('1 problem', '2,000 ticks')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}"
