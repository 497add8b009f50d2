"""Recordings: units converted, and everything that cannot be played refused with the place and a remedy."""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from scipy.io import netcdf_file as classic_file

from proofmass.blocks import RecordedSignal
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Place
from proofmass.runner.plan.recording import RecordingError, read_columns, read_recordings, split_unit


def read(path: Path, column: str = "", unit: str = "m/s^2") -> tuple[list[float], list[float]]:
    """Times and values of a recording as a block in this unit plays them."""
    block = RecordedSignal(file=path.name, column=column, unit=unit)
    place = Place("sensor.toml", {("blocks", "motion", "file"): 4, ("blocks", "motion", "column"): 5}, str(path.parent))
    graph = Graph(name="recorded", rate="1 kHz", blocks={"motion": block}, probes=["motion.output"], place=place)
    buffers = read_recordings(flatten(graph), "motion")
    assert set(buffers) == {"times", "values"}
    return list(buffers["times"]), list(buffers["values"])


def problem_of(path: Path, column: str = "", unit: str = "m/s^2") -> Problem:
    with pytest.raises(ModelError) as caught:
        read(path, column, unit)
    (problem,) = caught.value.problems
    return problem


def csv_file(folder: Path, text: str) -> Path:
    path = folder / "log.csv"
    path.write_text(text)
    return path


def parquet_file(folder: Path, columns: Mapping[str, Any], units: Mapping[str, str] | None = None) -> Path:
    table = pyarrow.table(dict(columns))
    units = units or {}
    fields = [f.with_metadata({"unit": units[f.name]}) if f.name in units else f for f in table.schema]
    pyarrow.parquet.write_table(table.cast(pyarrow.schema(fields)), folder / "log.parquet")
    return folder / "log.parquet"


def netcdf_file(folder: Path, variables: Mapping[str, tuple[str, Any, dict[str, Any]]]) -> Path:
    with h5netcdf.File(folder / "log.nc", "w") as file:
        for name, (dimension, values, attributes) in variables.items():
            if dimension not in file.dimensions:
                file.dimensions[dimension] = len(values)
            file.create_variable(name, (dimension,), data=np.asarray(values)).attrs.update(attributes)
    return folder / "log.nc"


# -- what is read ------------------------------------------------------------------------------------------------------


def test_the_recording_of_the_library_reads_through_its_comments() -> None:
    times, values = read(library_file("recorded_motion.csv"))
    assert len(times) == len(values) == 4000
    assert (times[0], times[1]) == (0.0, 0.005)
    assert 1.0 < max(values) < 20.0
    assert all(map(math.isfinite, values))


@pytest.mark.parametrize(
    ("head", "unit", "expected"),
    [
        ("time [s],force [mN]", "N", [1.0, 3.0]),
        ("time [s],force [N]", "mN", [1e6, 3e6]),
        ("time [s],force", "N", [1000.0, 3000.0]),
        ("time[s],force[mN]", "N", [1.0, 3.0]),
        (' "time [s]", "force, measured [kg*m/s^2]"', "N", [1000.0, 3000.0]),
        ("\ufefftime [s],force [ mN ]", "N", [1.0, 3.0]),
    ],
)
def test_a_csv_says_its_units_in_brackets(head: str, unit: str, expected: list[float], tmp_path: Path) -> None:
    path = csv_file(tmp_path, f"# by hand\n\n{head}\n0.0,1000\n# more\n0.5, 3e3 \n")
    assert read(path, unit=unit) == ([0.0, 0.5], expected)


def test_times_are_converted_to_seconds_and_each_number_rounded_once(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "time [ms],force [uN]\n" + "".join(f"{n},{n}\n" for n in range(1000)))
    times, values = read(path, unit="N")
    assert times == [n / 1000 for n in range(1000)]
    assert values == [n / 1_000_000 for n in range(1000)]


def test_columns_are_chosen_by_name_and_others_may_hold_anything(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "time [s],state,x [V],sums[0],sums[1] [1]\n0,idle,1,2,3\n1,,4,5,6\n")
    assert read(path, "x", "V") == ([0.0, 1.0], [1.0, 4.0])
    assert read(path, "sums[0]", "1")[1] == [2.0, 5.0]
    assert read(path, "sums[1]", "1")[1] == [3.0, 6.0]


def test_parquet_says_its_units_in_the_metadata_or_in_brackets(tmp_path: Path) -> None:
    columns = {"time": [0, 500], "force": [1.5, 2.5], "x [mV]": [3, 4], "on": [True, False]}
    path = parquet_file(tmp_path, columns, {"time": "ms", "force": "mN"})
    assert read(path, unit="N") == ([0.0, 0.5], [0.0015, 0.0025])
    assert read(path, "x", "V") == ([0.0, 0.5], [0.003, 0.004])
    assert read(path, "on", "1")[1] == [1.0, 0.0]


def test_netcdf_takes_the_times_of_the_variable_that_it_plays(tmp_path: Path) -> None:
    path = netcdf_file(
        tmp_path,
        {
            "slow": ("time_2", [7.0, 8.0], {"units": "V"}),
            "time_2": ("time_2", [0.0, 100.0], {"units": "ms"}),
            "fast": ("time", [1, 2, 3], {"units": "mN"}),
            "time": ("time", [0.0, 0.25, 0.5], {"units": "s"}),
        },
    )
    assert read(path, "fast", "N") == ([0.0, 0.25, 0.5], [0.001, 0.002, 0.003])
    assert read(path, "slow", "V") == ([0.0, 0.1], [7.0, 8.0])


def test_netcdf_of_packed_numbers_is_unpacked(tmp_path: Path) -> None:
    packed = {"units": "V", "scale_factor": 0.5, "add_offset": 10.0, "_FillValue": np.int16(-1)}
    variables: dict[str, Any] = {
        "time": ("obs", [0.0, 1.0], {"units": "s"}),
        "x": ("obs", np.array([2, 4], np.int16), packed),
    }
    assert read(netcdf_file(tmp_path, variables), unit="V") == ([0.0, 1.0], [11.0, 12.0])
    variables["x"] = ("obs", np.array([2, -1], np.int16), packed)
    assert problem_of(netcdf_file(tmp_path, variables), unit="V").message == "column x holds nan in row 2"


# -- what is refused ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "needs a row of column names such as time [s],acceleration [m/s^2]"),
        ("# only this\n", 1, "needs a row of column names such as time [s],acceleration [m/s^2]"),
        ("0.0,1.0\n0.1,2.0\n", 1, "needs a row of column names such as time [s],acceleration [m/s^2]"),
        ("# one\ntime [s]\n0.0\n", 2, "needs a row of column names such as time [s],acceleration [m/s^2]"),
        ("time,a\n0,1\n\n1,2,3\n", 4, "has 3 cells where the head has 2"),
        ("# one\ntime,a\n0,1\n1\n", 4, "has 1 cells where the head has 2"),
        ("time,a\n0,1\n1,nan\n", 3, "holds 'nan', which is not a finite number"),
        ("time,a\n0,1\n1,-inf\n", 3, "holds '-inf', which is not a finite number"),
        ("time,a\n0,1\n1,\n", 3, "holds '', which is not a finite number"),
        ("time,a\n0,1\n1,1_0\n", 3, "holds '1_0', which is not a finite number"),
        ("time,a\n0,1\n12:30,1\n", 3, "holds '12:30', which is not a finite number"),
        ('time,a\n0,1\n1,"2\n', 3, "unexpected end of data"),
    ],
)
def test_a_wrong_line_of_a_csv_is_named(text: str, line: int, message: str, tmp_path: Path) -> None:
    path = csv_file(tmp_path, text)
    problem = problem_of(path)
    assert (problem.file, problem.line, problem.message) == (str(path), line, message)
    assert problem.key == "blocks.motion.file"


def test_semicolons_are_told_from_commas(tmp_path: Path) -> None:
    assert problem_of(csv_file(tmp_path, "time;a\n0,5;1\n")).hint == "separate the columns by commas"


def test_a_problem_says_file_line_what_was_got_and_what_to_do(tmp_path: Path) -> None:
    csv_file(tmp_path, "time,a\n0,1\n")
    assert str(problem_of(tmp_path / "lug.csv")) == (
        "sensor.toml:4: blocks.motion.file: there is no such file\n"
        f"  got:      {tmp_path / 'lug.csv'}\n"
        "  hint:     did you mean log.csv?"
    )


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    assert problem_of(tmp_path / "nowhere" / "log.csv").hint == f"there is no folder {tmp_path / 'nowhere'}"


def test_no_file_at_all_is_refused(tmp_path: Path) -> None:
    graph = Graph(name="recorded", rate="1 kHz", blocks={"motion": RecordedSignal(unit="V")}, probes=["motion.output"])
    with pytest.raises(ModelError, match=r"says no file\n +hint: +write file = \"recording\.csv\""):
        read_recordings(flatten(graph), "motion")


def test_a_missing_column_is_named_with_the_nearest(tmp_path: Path) -> None:
    expected = "sensor.toml:5: blocks.motion.column: there is no column 'acceleraton'"
    for path in (
        csv_file(tmp_path, "time [s],acceleration [m/s^2],x [V]\n0,1,2\n"),
        parquet_file(tmp_path, {"time": [0.0], "acceleration": [1.0], "x": [1.0]}),
        netcdf_file(
            tmp_path, {"time": ("time", [0.0], {}), "acceleration": ("time", [0.0], {}), "x": ("time", [0.0], {})}
        ),
    ):
        first, *_, last = str(problem_of(path, "acceleraton")).splitlines()
        assert first == expected
        assert last == "  hint:     did you mean acceleration?"


def test_the_column_of_time_cannot_be_played_as_a_signal(tmp_path: Path) -> None:
    assert problem_of(csv_file(tmp_path, "time,a\n0,1\n"), "time").hint == "its columns: a."


@pytest.mark.parametrize(
    ("head", "message", "hint"),
    [
        ("time [s],a [V]", "column a is in V, not in m/s^2", "set the unit to V"),
        ("time [m],a [m/s^2]", "column time is in m, not in s", "set the unit to m"),
        ("time [s],a [m/s^]", "column a: an exponent must be a number such as 2, -1 or 0.5", ""),
        ("time [sec],a [m/s^2]", "column time: unknown unit 'sec'", ""),
    ],
)
def test_a_wrong_unit_is_refused(head: str, message: str, hint: str, tmp_path: Path) -> None:
    problem = problem_of(csv_file(tmp_path, f"{head}\n0,1\n"))
    assert (problem.message, problem.file, problem.line) == (message, "sensor.toml", 4)
    assert problem.hint.startswith(hint)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"time": [0.0, 1.0], "a": [1.0, None]}, "column a holds nan in row 2"),
        ({"time": [0.0, 1.0], "a": [math.inf, 1.0]}, "column a holds inf in row 1"),
        ({"time": [0.0, math.nan], "a": [1.0, 1.0]}, "column time holds nan in row 2"),
        ({"time": [0.0, 1.0], "a": ["1.0", "2.0"]}, "column a holds '1.0' in row 1, which is not a number"),
        ({"time": [0.0, 1.0], "a": [[1.0], [2.0]]}, "column a holds [1.0] in row 1, which is not a number"),
        ({"time": [0.0, 1.0, 1.0], "a": [1, 2, 3]}, "its time does not grow from row 2 to row 3: 1 s, 1 s"),
        ({"time": [0.0, 1.0, 0.5], "a": [1, 2, 3]}, "its time does not grow from row 2 to row 3: 1 s, 0.5 s"),
        ({"time": pyarrow.array([], "double"), "a": pyarrow.array([], "double")}, "holds no rows"),
        ({"time": [0.0, 1.0]}, "needs a column of time and one of values"),
    ],
)
def test_columns_that_cannot_be_played(columns: dict[str, Any], message: str, tmp_path: Path) -> None:
    assert problem_of(parquet_file(tmp_path, columns)).message == message


def test_a_csv_without_rows_is_refused(tmp_path: Path) -> None:
    assert problem_of(csv_file(tmp_path, "time,a\n")).message == "holds no rows"


def test_netcdf_without_times_is_refused(tmp_path: Path) -> None:
    problem = problem_of(netcdf_file(tmp_path, {"a": ("sample", [1.0], {})}))
    assert (problem.message, problem.hint) == ("has no variable with the times of a", "name it sample")


@pytest.mark.parametrize("kind", ["parquet", "nc"])
@pytest.mark.parametrize("damage", ["empty", "text", "cut", "flipped"])
def test_a_damaged_file_is_a_problem_not_a_crash(kind: str, damage: str, tmp_path: Path) -> None:
    if kind == "parquet":
        path = parquet_file(tmp_path, {"time": list(range(500)), "a": list(range(500))})
    else:
        path = netcdf_file(tmp_path, {"time": ("time", range(500), {}), "a": ("time", range(500), {})})
    whole = path.read_bytes()
    damaged = {
        "empty": b"",
        "text": b"time,a\n0,1\n",
        "cut": whole[: len(whole) // 2],
        "flipped": bytes(
            [*whole[:8], *(255 - byte for byte in whole[8:400]), *whole[400:-400], *[0xFF] * 396, *whole[-4:]]
        ),
    }
    path.write_bytes(damaged[damage])
    message = problem_of(path).message
    assert re.match('cannot be read: [^"]', message)
    assert "\n" not in message


def test_what_is_no_file_of_numbers_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    assert problem_of(tmp_path / "folder.csv").message == "is not a file"
    assert problem_of(Path("/dev/null")).hint == "the name must end in .csv, .parquet, .nc"
    (tmp_path / "latin.csv").write_bytes("time,größe\n0,1\n".encode("latin-1"))
    assert problem_of(tmp_path / "latin.csv").message.startswith("cannot be read: 'utf-8' codec can't decode byte")


# -- what was played without a word ------------------------------------------------------------------------------------


@pytest.mark.defect("C401", before="a classic netCDF file cannot be read: signature not found", after="it is read")
def test_classic_netcdf_is_read_like_that_of_version_4(tmp_path: Path) -> None:
    packed = {"units": "mm/s^2", "scale_factor": 0.5, "add_offset": 10.0}
    variables = {
        "time": ("time", np.array([0.0, 1.0, 2.5]), {"units": "ms"}),
        "level": ("time", np.array([1, 2, -4], dtype=np.int16), packed),
    }
    times, values = read(classic_netcdf_file(tmp_path, variables))
    assert times == [0.0, 0.001, 0.0025]
    assert values == [0.0105, 0.011, 0.008]


def classic_netcdf_file(folder: Path, variables: Mapping[str, tuple[str, Any, dict[str, Any]]]) -> Path:
    with classic_file(folder / "log.nc", "w") as file:
        for name, (dimension, values, attributes) in variables.items():
            if dimension not in file.dimensions:
                file.createDimension(dimension, len(values))
            variable = file.createVariable(name, values.dtype, (dimension,))
            variable[:] = values
            for key, value in attributes.items():
                setattr(variable, key, value)
    return folder / "log.nc"


@pytest.mark.defect("F7", before="the first of two columns of one name is played", after="refused, with the column")
@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_two_columns_of_one_name_are_refused(form: str, tmp_path: Path) -> None:
    path = csv_file(tmp_path, "time,a,b,a\n0,1,2,3\n")
    if form == "parquet":
        table = pyarrow.table([[0.0], [1.0], [3.0]], names=["time", "a [V]", "a [m/s^2]"])
        path = tmp_path / "log.parquet"
        pyarrow.parquet.write_table(table, path)
    problem = problem_of(path, "a")
    assert (problem.message, problem.line) == ("has 2 columns 'a'", 5)
    assert problem.key == "blocks.motion.column"


@pytest.mark.defect("F7", before="stamps of dates: the first value is played for ever", after="refused, with a cure")
def test_times_that_are_dates_are_refused(tmp_path: Path) -> None:
    problem = problem_of(csv_file(tmp_path, "time [s],a\n1700000000.0,1\n1700000000.5,2\n"))
    assert problem.message == "its first time is 1700000000 s, which looks like a date: a run begins at 0 s"
    assert problem.hint == "subtract 1700000000 s from its times"
    assert read(csv_file(tmp_path, "time [s],a\n0,1\n1700000000.5,2\n"))[0] == [0.0, 1700000000.5]
    late = [2e8, 3e8, 4.5e8]  # a mission of years: longer than it is since 0 s, so these are no dates
    assert read(csv_file(tmp_path, "time [s],a\n" + "".join(f"{time},1\n" for time in late)))[0] == late


def test_a_variable_with_times_of_its_own_is_chosen_beside_another_of_its_axis(tmp_path: Path) -> None:
    variables = {
        "time": ("time", [0.0, 0.5], {"units": "s"}),
        "tau": ("time", [1.0, 2.0], {"units": "s"}),
        "level": ("time", [3.0, 4.0], {"units": "V"}),
        "other": ("step", [5.0, 6.0], {"units": "V"}),
    }
    path = netcdf_file(tmp_path, variables)

    def chosen(first: str, second: str) -> list[list[float]]:
        pair = read_columns(path, lambda names: (names.index(first), names.index(second)))
        return [column.values.tolist() for column in pair]

    assert chosen("tau", "level") == [[1.0, 2.0], [3.0, 4.0]]
    with pytest.raises(RecordingError, match="tau and other are not on one time axis"):
        chosen("tau", "other")


@pytest.mark.defect(
    "S877", before="the first of two columns of one name, which another command refuses", after="refused"
)
def test_a_column_whose_name_another_has_is_refused_for_all_that_read_columns(tmp_path: Path) -> None:
    path = csv_file(tmp_path, "time [s],x [mV],x [V]\n0,1,2\n1,3,4\n")
    for chosen in ((0, 1), (0, 2)):
        with pytest.raises(RecordingError, match="has 2 columns 'x'"):
            read_columns(path, lambda names, chosen=chosen: chosen)  # type: ignore[misc]


@pytest.mark.defect("S878", before="-9999 V, where a file says that it stands for nothing", after="refused by row")
@pytest.mark.parametrize("attribute", ["_FillValue", "missing_value"])
def test_values_that_stand_for_nothing_are_none(attribute: str, tmp_path: Path) -> None:
    variables = {
        "time": ("time", [0.0, 1.0, 2.0], {"units": "s"}),
        "level": ("time", [1.0, -9999.0, 3.0], {"units": "V", attribute: -9999.0}),
    }
    with pytest.raises(RecordingError, match="column level holds nan in row 2"):
        read_columns(netcdf_file(tmp_path, variables), lambda names: (0, 1))


@pytest.mark.defect(
    "S908", before="millivolts of a head `level (mV)` were taken for volts", after="as those of `level [mV]`"
)
def test_a_unit_may_stand_in_round_brackets(tmp_path: Path) -> None:
    assert read(csv_file(tmp_path, "time (ms),level (mV)\n0,1\n250,2\n"), "level", "V") == ([0.0, 0.25], [0.001, 0.002])
    assert problem_of(csv_file(tmp_path, "time,level (mV)\n0,1\n1,2\n"), unit="N").message == (
        "column level is in mV, not in N"
    )


@pytest.mark.parametrize(
    ("head", "parts"),
    [
        ("rate (deg/s)", ("rate", "deg/s")),
        ("rate of turn ( deg/s )", ("rate of turn", "deg/s")),
        ("rate (1/s)", ("rate", "1/s")),
        ("rate (2)", ("rate (2)", "")),
        ("rate (raw)", ("rate (raw)", "")),
        ("f(s)", ("f(s)", "")),
        ("rate (raw) [deg/s]", ("rate (raw)", "deg/s")),
        ("(s)", ("(s)", "")),
    ],
)
def test_round_brackets_hold_a_unit_or_a_part_of_the_name(head: str, parts: tuple[str, str]) -> None:
    assert split_unit(head) == parts
