"""Graph files for tests: the library, a small one to break, and what is said about a text."""

from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.library import library_files
from proofmass.graphs.files.toml_reader import parsed, read_graph, read_table
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.studies.study_reader import is_study
from proofmass.graphs.tuning.check_file import CheckedFile, check_file, check_table

_FILES = [file for name, file in library_files().items() if name.endswith(".toml")]
_TABLES = {path: read_table(path)[0] for path in _FILES}
LIBRARY = [path for path, table in _TABLES.items() if not is_study(table)]
STUDIES = [path for path, table in _TABLES.items() if is_study(table)]  # of their own, beside the graph


def _runs_alone(path: Path) -> bool:
    """Whether it is no part; only one that exports something, or has no rate, is read whole: every test waits here."""
    table = _TABLES[path]
    return ("rate" in table and "exports" not in table) or runs_alone(flatten(read_graph(path)))


ALONE = [path for path in LIBRARY if _runs_alone(path)]  # the others are parts, with open inputs
# Made of parts that others have too: walks that run or compile every graph take them with all that is exhaustive.
OF_SAME_PARTS = {
    "calibration_interval_study",
    "cavity_accelerometer",
    "chopped_accelerometer",
    "disk_resonator_gyroscope",
    "fibre_optic_gyroscope",
    "force_balance_seismometer",
    "gyroscope_capacitances",
    "gyroscope_noise",
    "gyroscope_rate_response",
    "half_power_sweep",
    "hemispherical_rebalance",
    "hemispherical_whole_angle",
    "imu_3dof",
    "magnetic_encoder",
    "mems_microphone",
    "michelson_accelerometer",
    "open_loop_gyroscope",
    "pn_self_test_accelerometer",
    "quartz_error_terms",
    "quartz_feedback_gain",
    "quartz_feedback_noise",
    "quartz_forward_gain",
    "quartz_thermometer",
    "resonant_accelerometer",
    "scale_factor_drift",
    "self_calibration_gyroscope",
    "self_calibration_gyroscope_fixed",
    "self_calibration_online",
    "self_calibration_population",
    "sigma_delta_accelerometer",
    "six_axis_imu",
    "strain_bridge",
    "temperature_compensation_drift",
    "temperature_compensation_m2",
    "temperature_compensation_polynomial",
}
WALKED = [
    pytest.param(path, id=path.stem, marks=pytest.mark.exhaustive if path.stem in OF_SAME_PARTS else ())
    for path in ALONE
]
# Of each kind one: where every graph is interpreted, these are compiled too. All of them are in test_engines_agree.
COMPILED = {
    "closed_loop_accelerometer",
    "pn_self_test_minimal",
    "quartz_calibration",
    "self_calibration_fixed",
    "temperature_compensation_m1",
    "vibratory_gyroscope",
}

SMALL = """\
name = "a mass and a converter"
rate = "10 kHz"
duration = "1 s"
wires = [
    "push.output -> mass.force",
    "mass.displacement -> readout.input",
    "readout.output -> adc.voltage",
]
probes = ["adc.code"]

[blocks.push]
kind = "Constant"
value = "1 uN"
unit = "N"

[blocks.mass]
kind = "MassSpringDamper"

[blocks.readout]
kind = "Gain"
gain = "1e6 V/m"
input_unit = "m"
output_unit = "V"

[blocks.adc]
kind = "AnalogToDigital"
bits = 16
"""


def check_text(text: str, file: str = "<text>", folder: str = ".") -> CheckedFile:
    """The graph of a text, and what is wrong with it; file names in it start from `folder`."""
    try:
        return check_table(*parsed(text, file, folder), None, None)
    except ModelError as error:
        return CheckedFile(None, list(error.problems))


def problems_of(text: str, file: str = "model.toml", folder: str = ".") -> list[Problem]:
    """Everything that reading and checking say about a text."""
    return check_text(text, file, folder=folder).problems


def said_about(path: Path) -> str:
    """What a user sees, with the file's name instead of its path."""
    return "\n".join(map(str, check_file(path).problems)).replace(str(path), path.name)


def changed(text: str, old: str, new: str) -> str:
    """The text with one piece replaced; the piece must be there once."""
    assert text.count(old) == 1, f"{old!r} is there {text.count(old)} times"
    return text.replace(old, new)


def line_of(text: str, piece: str) -> int:
    """Line of the first place of a piece."""
    return text.count("\n", 0, text.index(piece)) + 1
