"""Ages of sensors in words."""

HOUR, YEAR = 3600.0, 31557600.0  # seconds


def age_text(seconds: float) -> str:
    """An age in the unit that suits it.

    >>> age_text(0.0), age_text(3.6e6), age_text(31557600.0)
    ('0 h', '1000 h', '1 year')
    """
    if seconds < YEAR:
        return f"{seconds / HOUR:g} h"
    return f"{seconds / YEAR:g} year"
