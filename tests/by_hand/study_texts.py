"""A small study for tests: a noisy converter with a reference that differs, is swept and ages."""

STUDY = """\
name = "a converter that ages"
rate = "1 kHz"
samples = 60
wires = [
    "source.output -> sum.first",
    "noise.output -> sum.second",
    "sum.output -> filter.input",
    "filter.output -> adc.voltage",
]
probes = ["adc.code"]

[measures]
bias = { signal = "adc.number", statistic = "mean", from = "20 ms" }
noise = { signal = "adc.code", statistic = "std", from = "20 ms" }

[blocks]
source = { kind = "Constant", value = "1 V", unit = "V" }
noise = { kind = "WhiteNoise", density = "1 mV/sqrt(Hz)", unit = "V" }
sum = { kind = "Sum", unit = "V" }
filter = { kind = "LowPass", corner_frequency = "100 Hz", input_unit = "V", output_unit = "V" }
adc = { kind = "AnalogToDigital", bits = 12, reference = "5 V" }

[study]
runs = 6
seed = 11

[study.spread]
"adc.reference" = { normal = "200 ppm", relative = true }
"source.value" = { uniform = "1 mV" }

[study.sweep]
"filter.corner_frequency" = ["100 Hz", "200 Hz"]

[study.epochs]
ages = ["0 h", "1000 h", "1 year"]

[study.drift]
"adc.reference" = { ramp = "20 ppm/year", ramp_spread = "5 ppm/year", random_walk = "9 ppm/sqrt(year)", relative=true}

[study.limits]
bias = { change = "100 ppm" }
noise = { at_most = 100 }
"""

# The same sensor with everything that a study may say.
RICH = (
    STUDY.partition("[study]")[0]
    + """\
[study]
runs = 8
seed = 5
design = "latin_hypercube"

[study.spread]
"adc.reference" = { normal = "200 ppm", relative = true }
"source.value" = { file = "lot.csv", column = "offset" }
"noise.density" = { lognormal = 0.1 }
"filter.corner_frequency" = { values = ["100 Hz", "200 Hz"], weights = [3, 1] }

[study.correlation]
"noise.density" = { "adc.reference" = -0.5 }

[study.epochs]
ages = ["0 h", "1 year"]

[study.drift]
"adc.reference" = { arrhenius = "4 ppm/year", temperature = "328 K", relative = true }

[study.limits]
bias = { at_least = 0, change = "100 ppm" }

[study.stop]
bias = 0.5
"""
)

CALIBRATED = """\
name = "an amplifier whose gain is made up for by a register"
rate = "1 kHz"
samples = 20
wires = [
    "source.output -> amplifier.input",
    "amplifier.output -> noisy.first",
    "noise.output -> noisy.second",
    "noisy.output -> corrected.first",
    "register.value -> corrected.second",
    "corrected.output -> error.first",
    "minus_one.output -> error.second",
    "error.output -> register.deviation",
    "slots.finished -> register.load",
    "width.output -> slope.input",
]
probes = ["corrected.output"]

[measures]
found = { signal = "corrected.output", statistic = "max" }
register = { signal = "register.value", statistic = "last" }

[blocks]
source = { kind = "Constant", value = 1 }
amplifier = { kind = "Gain" }
noise = { kind = "WhiteNoise", density = "1e-6 1/sqrt(Hz)" }
noisy = { kind = "Sum" }
corrected = { kind = "Product" }
minus_one = { kind = "Constant", value = -1 }
error = { kind = "Sum" }
register = { kind = "CompensationRegister", limit = 0.5 }
slots = { kind = "MeasurementSlots", slots = 1, settling = "10 ms", averaging = "1 ms" }
width = { kind = "Constant", value = "1 m", unit = "m" }
slope = { kind = "Gain", input_unit = "m", gain = "1 1/m" }

[study]
runs = 4
seed = 5

[study.epochs]
every = "1 year"
until = "4 year"

[study.drift]
"amplifier.gain" = { ramp = "0.01 1/year", ramp_spread = "0.001 1/year" }

[study.recalibration]
every = ["never", "2 year", "1 year"]
carried = { "register.initial" = "register" }
"""

# A study whose graph plays a recording, data/source.csv, through a block of the user's own, of triple.py.
RECORDED = """\
name = "a recording, three times as large"
rate = "1 kHz"
samples = 30
wires = ["source.output -> triple.input", "triple.output -> gain.input"]

[measures]
mean = { signal = "gain.output", statistic = "mean" }

[blocks]
source = { kind = "RecordedSignal", file = "data/source.csv" }
triple = { kind = "Triple" }
gain = { kind = "Gain" }

[study]
runs = 6

[study.spread]
"gain.gain" = { normal = 0.1 }
"""

RECORDING = "time,volts\n0,1\n0.01,1.5\n0.02,-2\n"

TRIPLE = '''\
"""Three times the input."""

from proofmass import Block, Input

FACTOR = 3.0


class Triple(Block):
    """Three times the input."""

    input = Input("1", "Any number.")


@Triple.output("1")
def output(p: Triple, input: float) -> float:
    """Three times it."""
    return FACTOR * input
'''
