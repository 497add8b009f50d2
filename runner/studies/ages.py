"""Ages and intervals between calibrations in words."""

import math

HOUR, MONTH, YEAR = 3600.0, 2629800.0, 31557600.0  # seconds


def age_text(seconds: float) -> str:
    """An age in the unit that suits it.

    >>> age_text(0.0), age_text(3.6e6), age_text(7889400.0), age_text(31557600.0)
    ('0 h', '1000 h', '3 month', '1 year')
    """
    if seconds >= YEAR:
        return f"{seconds / YEAR:g} year"
    months = seconds / MONTH
    return f"{months:.0f} month" if months >= 1.0 and months == round(months) else f"{seconds / HOUR:g} h"


def recalibration_text(seconds: float) -> str:
    """How often sensors are calibrated.

    >>> recalibration_text(31557600.0), recalibration_text(math.inf)
    ('recalibrated every 1 year', 'never recalibrated')
    """
    return "never recalibrated" if seconds == math.inf else f"recalibrated every {age_text(seconds)}"
