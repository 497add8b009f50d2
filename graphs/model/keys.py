"""Keys of the tables in a graph file, and what they mean: for the reader, the schema and hints.

Those at the top of the file stand at the fields of `graph.Graph`.
"""

from dataclasses import field
from typing import Any, NamedTuple, TypeGuard

from proofmass.graphs.model.limits import LARGEST_SEED, LARGEST_STUDY


class Text(NamedTuple):
    """A text of at most so many characters; empty by default."""

    longest: int = 10_000


class Integer(NamedTuple):
    """An integer within two bounds; by default a number or, where that is None, missing."""

    lowest: int
    highest: int
    default: int | None

    def whole(self, value: object) -> TypeGuard[int]:
        """Return whether a value is an integer at all."""
        return isinstance(value, int) and not isinstance(value, bool)

    def holds(self, value: object) -> bool:
        """Return whether a value is an integer within the bounds."""
        return self.whole(value) and self.lowest <= value <= self.highest


def key(meaning: str, form: Text | Integer | None = None) -> Any:
    """Return a field that is a key of graph files too; `form` says all that a plain text or integer may be."""
    return field(metadata={"meaning": meaning, "form": form})


STUDY_INTEGERS = {"runs": Integer(1, LARGEST_STUDY, 100), "seed": Integer(0, LARGEST_SEED, 0)}
TUNE_INTEGERS = {
    "starts": Integer(1, 100, 4),
    "samples": Integer(1, 100_000, 64),
    "seed": Integer(0, LARGEST_SEED, 0),
}
BLOCK_KEYS = {  # of every block, beside its parameters
    "kind": "Kind of the block; `proofmass blocks` lists them.",
    "rate": "Rate of this block, where it differs from the graph's.",
    "clock_offset": 'How much later than tick 0 its first tick is, less than its period: "25 us"; 0 unless said.',
}
OWN_MEASURE_KEYS = {  # beside the options of its statistic
    "signal": 'Output that is reduced to one number, "block.output".',
    "statistic": "How the signal is reduced to one number.",
    "from": "From which time on; from the start when nothing is said.",
    "until": "Until which time; to the end when nothing is said.",
    "unit": 'In which unit tables show it, such as "deg/h"; its value stays in that of the signal.',
}
FORMULA = "formula"
MEASURE_FORMULA_KEYS = {  # of a measure that follows from others
    FORMULA: 'Formula of other measures, "= (plus - minus) / 2".',
    "unit": 'In which unit tables show it, such as "deg/h"; its value stays in that of the formula.',
}
PART_KEYS = {  # of a block that is a graph, beside parameters inside it
    "graph": 'File of the graph, in the same folder or below it, or "library:NAME.toml" for one that comes along.',
    "rate": "Rate of the blocks inside that have none of their own.",
    "clock_offset": "How much later all blocks inside tick, beside their own offsets.",
    "count": "How many there are, named NAME_1, NAME_2 and so on.",
}
LOOP_KEYS = {
    "open_at": "Output at which the loop is opened: all of the loop goes through it.",
    "gain_margin": 'Least factor, as "6 dB", by which the gain may rise or fall before the loop is unstable.',
    "phase_margin": 'Least phase, as "30 deg", that makes the loop unstable.',
    "delay_margin": 'Least delay, as "100 us", that makes the loop unstable.',
    "sensitivity_peak": 'Largest amplification of a disturbance, as "6 dB".',
}
REQUIREMENT_KEYS = {
    "text": "What is required, in words.",
    "quantity": 'A measure, "bias"; a margin, "main.phase_margin"; "yield.bias"; or a table as goals of [tune] have.',
    "at_least": "Smallest value that meets it, a number in the unit of the quantity or a text with its own.",
    "at_most": "Largest value that meets it.",
    "at": 'Operating point of a linearised quantity: the time, "0 s" when nothing is said, or "settled".',
    "tolerances": 'The limits hold for the worst case within these: { "pid.gain" = "5 %" }, or "spread" of [study].',
    "proved": "A margin, scale factor, bias, peak or noise is proved for all sensors within the tolerances.",
}
STUDY_KEYS = {
    "graph": 'File of the graph, in the same folder or below it, or "library:NAME.toml".',
    "runs": "How many sensors are drawn, at each point of the sweep.",
    "seed": "Seed of everything that is drawn, and of the noise.",
    "design": "How sensors are drawn: random when nothing is said, latin_hypercube, sobol or saltelli.",
    "spread": 'What differs from sensor to sensor: "adc.reference" = { normal = "200 ppm", relative = true }.',
    "correlation": 'Of normal parameters: "adc.reference" = { "source.value" = 0.5 }.',
    "sweep": 'Parameters that take each of some values, "adc.reference" = ["2.5 V", "5 V"]; several make a grid.',
    "epochs": 'Ages at which sensors are looked at: ages = ["0 h", "1 year"], or every = "1 month", until = "1 year".',
    "recalibration": 'Calibrations: every = "1 year"; carried = { "gain.initial" = "gain_found" } is what they leave.',
    "margins": 'The margins of the loops are measures too, at that time, as "0 s", or "auto" or "settled".',
    "drift": 'Parameters that age from epoch to epoch: "adc.reference" = { ramp = "20 ppm/year", relative = true }.',
    "changes": 'Changes of measures as measures: bias_drift = { measure = "bias", since = "calibration" }.',
    "missions": "Temperatures that a sensor goes through again and again, for laws of drift: phases, points or a file.",
    "limits": "What a good sensor keeps: bias = { at_least = -1, at_most = 1, change = 1e-3 }.",
    "variants": 'Designs with names, each with the same sensors: cheap = { set = { "adc.bits" = 12 } }.',
    "stop": 'When it has run enough: bias = "1 uV", half of the 95 % confidence interval of the mean.',
}
EPOCH_KEYS = {
    "ages": "Ages, ascending.",
    "every": "Instead of ages: how much age goes by from epoch to epoch.",
    "until": "The last age.",
}
RECALIBRATION_KEYS = {
    "every": 'How much age goes by between calibrations, "1 year", or "never"; a list compares.',
    "carried": "Parameters that keep a measure of the last calibration: a parameter, and the name of the measure.",
}
MISSION_KEYS = {
    "phases": 'Phases that follow each other, then begin anew: [{ temperature = "358 K", for = "16 h" }].',
    "points": 'Times and temperatures with straight lines between them: [["0 h", "233 K"], ["24 h", "358 K"]].',
    "file": "A CSV file with columns of times and temperatures, beside the study.",
    "time": "Its column of times, time when nothing is said.",
    "temperature": "Its column of temperatures, temperature when nothing is said.",
}
PHASE_KEYS = {"temperature": "Temperature of a phase.", "for": "How long it lasts."}
CHANGE_KEYS = {
    "measure": "The measure that changes.",
    "since": 'An age, "1 year", or the last "calibration"; since the first epoch when nothing is said.',
    "relative": "true: relative to the value at that time.",
}
LIMIT_KEYS = {
    "at_least": "Smallest value of the measure in a good sensor.",
    "at_most": "Largest value of the measure in a good sensor.",
    "change": "Largest change from the first epoch that counts, relative to the value there.",
    "from": "Age from which on the limit counts, 0 when nothing is said.",
}
TUNE_KEYS = {
    "free": 'Free parameters: "pid.integral" = { at_least = "1 1/s", at_most = "100 1/s" }.',
    "goals": 'What is wanted: phase = { loop = "main", figure = "phase_margin", at_least = "60 deg" }.',
    "points": 'Operating points at which all goals hold: hot = { "temperature.value" = "358 K" }.',
    "tolerances": 'All goals hold at all corners of these too: "torquer.gain" = "5 %".',
    "ages": 'Ages at which all goals hold, with the drift of [study]: ["0 h", "15 year"]; new when nothing is said.',
    "at": 'Linearise at this time, "20 ms", or where the loops have "settled"; the start unless said.',
    "starts": "From how many of the best samples the search starts, 4 when nothing is said.",
    "samples": "How many points are tried first, 64 when nothing is said.",
    "seed": "Seed of these points.",
}
FREE_KEYS = {
    "at_least": "Lower bound of the parameter.",
    "at_most": "Upper bound of the parameter.",
    "scale": "Axis on which samples lie evenly: linear or logarithmic; by the bounds when nothing is said.",
}
GOAL_KEYS = {  # beside those that name the quantity
    "at_least": "Smallest value that is wanted.",
    "at_most": "Largest value that is wanted.",
    "soft": "true: the limit is met as well as the other goals allow.",
    "minimise": "true: as low as the other goals allow.",
    "maximise": "true: as high as the other goals allow.",
}
