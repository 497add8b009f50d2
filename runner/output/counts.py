"""Numbers with their nouns, and texts that are numbers."""


def count(number: int, noun: str) -> str:
    """Return a number with its noun.

    >>> count(1, "problem"), count(2000, "tick")
    ('1 problem', '2,000 ticks')
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def is_number(text: str) -> bool:
    """Return whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
