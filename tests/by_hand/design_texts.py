"""Graphs for tests of tuning, fits and worst cases, each with a closed form.

`INTEGRATING` has the loop gain K T / (z - 1) / z: K T = 2 sin(w T / 2) at the crossover w, and a phase margin of
90 deg - 1.5 w T.
`RESONATOR` is a mass on a spring. `COUPLED` are two integrating loops that disturb each other.
"""

INTEGRATING = """\
name = "an integrating loop"
rate = "1 kHz"
duration = "0.5 s"
wires = [
    "wanted.output -> error.first",
    "seen.output -> error.second",
    "error.output -> controller.input",
    "controller.output -> computing.input",
    "computing.output -> plant.input",
    "plant.output -> seen.first",
    "hiss.output -> seen.second",
]
probes = ["plant.output"]

[loops.main]
open_at = "controller.output"

[measures]
end = { signal = "plant.output", statistic = "last" }
top = { signal = "plant.output", statistic = "max" }

[blocks.wanted]
kind = "Step"
amplitude = 1.0

[blocks.error]
kind = "Difference"

[blocks.controller]      # K
kind = "Gain"
gain = 100.0             # slow at first

[blocks.computing]
kind = "UnitDelay"

[blocks.plant]
kind = "DiscreteIntegrator"
output_unit = "1"

[blocks.seen]
kind = "Sum"

[blocks.hiss]
kind = "WhiteNoise"
density = "1e-3 1/sqrt(Hz)"
"""

TUNE = """
[tune.free]
"controller.gain" = { at_least = 1.0, at_most = 1000.0 }   # K

[tune.goals]
phase = { loop = "main", figure = "phase_margin", at_least = "60 deg" }
fast = { loop = "main", figure = "bandwidth", maximise = true }
"""

RESONATOR = """\
name = "a resonator"
rate = "20 kHz"
duration = "0.1 s"
wires = [
    "force.output -> sensor.force",
    "sensor.displacement -> readout.displacement",
    "readout.voltage -> seen.first",
    "hiss.output -> seen.second",
]
probes = ["force.output", "seen.output"]

[blocks.force]
kind = "Constant"
value = "1 uN"
unit = "N"

[blocks.sensor]             # the device
kind = "MassSpringDamper"
mass = "50 ug"
stiffness = "5 N/m"         # as designed
damping = "5e-5 kg/s"

[blocks.readout]
kind = "DisplacementReadout"
gain = "1e6 V/m"

[blocks.hiss]
kind = "WhiteNoise"
unit = "V"
density = "1 mV/sqrt(Hz)"

[blocks.seen]
kind = "Sum"
unit = "V"
"""

COUPLED = """\
name = "two coupled loops"
rate = "1 kHz"
duration = "0.1 s"
wires = [
    "x_plant.output -> x_sum.first",
    "y_plant.output -> x_cross.input",
    "x_cross.output -> x_sum.second",
    "x_sum.output -> x_minus.input",
    "x_minus.output -> x_gain.input",
    "x_gain.output -> x_delay.input",
    "x_delay.output -> x_plant.input",
    "y_plant.output -> y_sum.first",
    "x_plant.output -> y_cross.input",
    "y_cross.output -> y_sum.second",
    "y_sum.output -> y_minus.input",
    "y_minus.output -> y_gain.input",
    "y_gain.output -> y_delay.input",
    "y_delay.output -> y_plant.input",
]
probes = ["x_plant.output"]
loops = { x = { open_at = "x_gain.output" }, y = { open_at = "y_gain.output" } }

[blocks]
x_plant = { kind = "DiscreteIntegrator", output_unit = "1" }
y_plant = { kind = "DiscreteIntegrator", output_unit = "1" }
x_cross = { kind = "Gain", gain = 0.6 }
y_cross = { kind = "Gain", gain = -0.9 }
x_sum = { kind = "Sum" }
y_sum = { kind = "Sum" }
x_minus = { kind = "Negation" }
y_minus = { kind = "Negation" }
x_gain = { kind = "Gain", gain = 200.0 }
y_gain = { kind = "Gain", gain = 120.0 }
x_delay = { kind = "UnitDelay" }
y_delay = { kind = "UnitDelay" }
"""
