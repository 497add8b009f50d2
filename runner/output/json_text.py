"""Plain data as JSON, which knows neither NaN nor infinity."""

import json
import math
from collections.abc import Mapping
from typing import Any


def json_text(data: Any, indent: int = 2, *, ensure_ascii: bool = True) -> str:
    """Return JSON with null for numbers that have no value or no limit.

    >>> json_text({"settled": float("nan"), "interval": (0.0, float("inf"))}, indent=0).replace("\\n", "")
    '{"settled": null,"interval": [0.0,null]}'
    """
    return json.dumps(_known(data), indent=indent, ensure_ascii=ensure_ascii, allow_nan=False)


def finite(number: float | None) -> float | None:
    """Return a number, or None if it has no value or no limit."""
    return number if number is not None and math.isfinite(number) else None


def _known(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {key: _known(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_known(value) for value in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data
