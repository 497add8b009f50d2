"""Variables of netCDF that are packed into small numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import netcdf_file

from proofmass.runner.plan.recording import RecordingError, _unpacked, _Variable, read_columns


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


FILLED = 15.0 * 2.0**119  # 9.969209968386869e36


@pytest.mark.defect(
    "S907", before="what a netCDF library puts where nothing was written was played", after="is missing"
)
@pytest.mark.parametrize(
    ("kind", "filled"),
    [
        (">f8", FILLED),
        ("<f4", FILLED),
        (">i2", -32767),
        ("<i4", -2147483647),
        ("<i8", -9223372036854775806),
        ("<u2", 65535),
        ("<u8", 18446744073709551614),
    ],
)
def test_values_that_nobody_wrote_are_missing(kind: str, filled: float) -> None:
    """`NC_FILL` of netcdf.h: values of a variable that does not say its own, but for bytes."""
    held = np.array([1, filled, 3], kind)
    with pytest.raises(RecordingError, match="holds nan in row 2"):
        _unpacked("force", _Variable(held, {}))
    own = {"_FillValue": np.array(7, kind)}
    assert _unpacked("force", _Variable(held, own)).values.tolist() == [1.0, float(held[1]), 3.0]


def test_a_byte_has_no_value_that_nobody_wrote() -> None:
    held = np.array([1, -127, 3], np.int8)
    assert _unpacked("force", _Variable(held, {})).values.tolist() == [1.0, -127.0, 3.0]


@pytest.mark.parametrize("written", [[0], [0, 1, 2]])
def test_a_classic_file_that_was_not_filled_is_refused(written: list[int], tmp_path: Path) -> None:
    path = tmp_path / "half.nc"
    with netcdf_file(path, "w") as file:
        file.createDimension("time", 3)
        for name, value in (("time", 1.0), ("level", 2.0)):
            variable = file.createVariable(name, "d", ("time",))
            variable[:] = FILLED
            for row in range(3) if name == "time" else written:
                variable[row] = value + row
    if len(written) == 3:
        assert read_columns(path, lambda names: (0, 1))[1].values.tolist() == [2.0, 3.0, 4.0]
        return
    with pytest.raises(RecordingError, match="column level holds nan in row 2"):
        read_columns(path, lambda names: (0, 1))
