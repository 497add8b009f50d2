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


@pytest.mark.defect("S899", before="a byte of 255 was played as -1", after="255")
@pytest.mark.parametrize(
    ("kind", "attributes", "values"),
    [
        (np.int8, {"_Unsigned": "true"}, [1.0, 255.0, 128.0]),
        (">i2", {"_Unsigned": "true", "scale_factor": 0.5, "add_offset": 10.0}, [10.5, 32777.5, 32714.0]),
        (np.int8, {"_Unsigned": "false"}, [1.0, -1.0, -128.0]),
    ],
)
def test_integers_that_are_said_to_be_unsigned(kind: Any, attributes: dict[str, Any], values: list[float]) -> None:
    """Of n bits a negative number stands for 2^n more; (65535, 65408) / 2 + 10 of 16 bits."""
    held = np.array([1, -1, -128], kind)
    assert _unpacked("force", _Variable(held, attributes)).values.tolist() == values
    with pytest.raises(RecordingError, match="holds nan in row 2"):
        _unpacked("force", _Variable(held, {**attributes, "_FillValue": np.int8(-1)}))


@pytest.mark.defect("C881", before="TypeError inside proofmass", after="any of them is missing")
def test_several_missing_values() -> None:
    several = {"missing_value": np.array([-99.0, -98.0])}
    assert _unpacked("force", _Variable(np.array([1.0, 2.0]), several)).values.tolist() == [1.0, 2.0]
    with pytest.raises(RecordingError, match="holds nan in row 2"):
        _unpacked("force", _Variable(np.array([1.0, -98.0]), several))


@pytest.mark.defect("S906", before="values beyond the limits of a netCDF variable were played", after="are missing")
@pytest.mark.parametrize(
    ("limits", "row"),
    [
        ({"valid_range": [-10, 100]}, 3),
        ({"valid_max": 100}, 3),
        ({"valid_min": 2}, 1),
        ({"valid_range": [-10, 100], "scale_factor": 10.0}, 3),  # of what is stored
        ({"valid_range": [0, 254], "_Unsigned": "true"}, 4),
        ({"valid_min": -1, "valid_max": 127}, None),
    ],
)
def test_values_beyond_the_limits_of_a_variable_are_missing(limits: dict[str, Any], row: int | None) -> None:
    """NetCDF users guide, attribute conventions: of packed data limits are those of the packed values."""
    variable = _Variable(np.array([1, 100, 101, -1], np.int8), limits)
    if row is None:
        assert _unpacked("force", variable).values.tolist() == [1.0, 100.0, 101.0, -1.0]
        return
    with pytest.raises(RecordingError, match=f"holds nan in row {row}"):
        _unpacked("force", variable)
