"""Pictures of two noise budgets, into docs/pictures: a closed-loop quartz accelerometer and a gyroscope.

    python -m docs.noise_pictures

The quartz accelerometer is that of the library with three sources on top: Brownian torque on its flexure at 300 K,
voltage noise of 50 nV/sqrt(Hz) behind its amplifier, and 2 uV/sqrt(Hz) with flicker below 10 Hz on the torquer's
reference. The gyroscope is the one that calibrates itself.
"""

import math
from pathlib import Path

from proofmass import Graph, NoiseBudget, noise, read_graph
from proofmass.blocks import FlickerNoise, Sum, WhiteNoise
from proofmass.graphs.model.graph import Wire
from proofmass.runner.analysis.noise.plot import plot_noise
from proofmass.runner.output.pictures import save_figure

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
_BOLTZMANN, _TEMPERATURE = 1.380649e-23, 300.0


def quartz() -> Graph:
    """Return the quartz accelerometer with its noise."""
    graph = read_graph(ROOT / "graphs/library/quartz/quartz_accelerometer.toml")
    damping = float(graph.blocks["pendulum"].damping)  # type: ignore[attr-defined]
    torque = math.sqrt(4.0 * _BOLTZMANN * _TEMPERATURE * damping)
    own = {
        "brownian": WhiteNoise(density=torque, unit="N*m"),
        "amplifier_noise": WhiteNoise(density=50e-9, unit="V"),
        "flicker": FlickerNoise(level=1e-7, lowest_frequency=1e-2, highest_frequency=1e3, nominal=5.0, unit="V"),
        "amplified": Sum(unit="V"),
        "wandering": Sum(unit="V"),
        "five_volts": type(graph.blocks["n_vref"])(value=-5.0, unit="V"),
    }
    moved = {"amplifier.output": "amplified.output", "da0.voltage": "wandering.output"}
    wires = [Wire(moved.get(wire.source, wire.source), wire.target) for wire in graph.wires]
    wires += [
        Wire("amplifier.output", "amplified.first"), Wire("amplifier_noise.output", "amplified.second"),
        Wire("da0.voltage", "wandering.first"), Wire("flicker.value", "wandering.second"),
        Wire("five_volts.output", "wandering.third"), Wire("brownian.output", "torque.third"),
    ]  # fmt: skip
    return graph.changed(blocks={**graph.blocks, **own}, wires=tuple(wires))


def gyroscope() -> Graph:
    """Return the gyroscope that calibrates itself."""
    return read_graph(ROOT / "graphs/library/gyroscope/self_calibration_gyroscope.toml")


def budgets() -> dict[str, NoiseBudget]:
    """Return the two budgets by the names of their pictures."""
    return {
        "noise_quartz": noise(
            quartz(), "output.number", input="specific_force.output", band=(0.1, 300.0), at="periodic"
        ),
        "noise_gyroscope": noise(gyroscope(), "adc.number"),
    }


def main() -> None:
    """Draw both."""
    for name, budget in budgets().items():
        print(save_figure(plot_noise(budget), PICTURES / f"{name}.png"))


if __name__ == "__main__":
    main()
