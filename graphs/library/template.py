"""A mechanical accelerometer that is read by a 16-bit converter, with a block of its own. Run it with: python FILE"""

from proofmass import Block, Graph, Input, param, simulate
from proofmass.blocks import AnalogToDigital, Gain, MassSpringDamper, Sine


class Readout(Block):
    """Voltage of a displacement: voltage = sensitivity * displacement."""

    sensitivity: float = param("V/m", "Voltage per displacement.", default=3.53e8, above=0.0)

    displacement = Input("m", "Displacement that is read.")


@Readout.output("V")
def voltage(p: Readout, displacement: float) -> float:
    """Voltage of the displacement."""
    return p.sensitivity * displacement


graph = Graph(
    name="my accelerometer",
    rate="10 kHz",  # of every block that does not say another
    duration="50 ms",
    blocks={  # names of your own; numbers are in the unit of the parameter, and "50.43 ug" is converted to it
        "acceleration": Sine(unit="m/s^2", amplitude=9.80665, frequency=90.0),
        "inertia": Gain(gain=50.43e-9, input_unit="m/s^2", output_unit="N"),  # force = m a
        "sensor": MassSpringDamper(mass=50.43e-9, damping=3.4e-3, stiffness=49.5627),
        "readout": Readout(),
        "adc": AnalogToDigital(bits=16, reference=10.0),
    },
    wires=[  # "block.output -> block.input"; a wire to a parameter drives the parameter
        "acceleration.output -> inertia.input",
        "inertia.output -> sensor.force",
        "sensor.displacement -> readout.displacement",
        "readout.voltage -> adc.voltage",
    ],
    probes=["sensor.displacement", "adc.code"],  # what is recorded
)

if __name__ == "__main__":
    result = simulate(graph)
    print(f"largest code: {max(abs(result['adc.code'].values))}")
