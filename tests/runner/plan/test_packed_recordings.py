"""Variables of netCDF that are packed into small numbers."""

from typing import Any

import numpy as np
import pytest

from proofmass.runner.plan.recording import RecordingError, _unpacked, _Variable


@pytest.mark.parametrize(
    ("attributes", "values"),
    [
        ({}, [1.0, 2.0, -99.0]),
        ({"scale_factor": 0.5}, [0.5, 1.0, -49.5]),
        ({"add_offset": 10.0}, [11.0, 12.0, -89.0]),
        ({"scale_factor": 0.5, "add_offset": 10.0, "units": "mV"}, [10.5, 11.0, -39.5]),
    ],
)
def test_packed_numbers_are_scaled_and_then_moved(attributes: dict[str, Any], values: list[float]) -> None:
    """The conventions of netCDF: packed * scale_factor + add_offset; texts without these are refused as such."""
    column = _unpacked("force", _Variable(np.array([1, 2, -99]), attributes))
    assert (column.name, column.unit, column.values.tolist()) == ("force", attributes.get("units", ""), values)
    with pytest.raises(RecordingError, match="holds nan in row 3"):
        _unpacked("force", _Variable(np.array([1, 2, -99]), {**attributes, "_FillValue": -99}))
    with pytest.raises(RecordingError, match="holds 'a' in row 1, which is not a number"):
        _unpacked("force", _Variable(np.array(["a"]), {}))
