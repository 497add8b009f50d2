"""The small loop of docs/coming-from in every tool that is installed: CPU time a tick, and what each answers.

python benchmarks/peers.py

proofmass, a loop by hand and python-control run always; pathsim, bdsim, Drake and ngspice where they are installed.
A sampled integrator of 1 kHz controls a lag of 10 ms. The cost of a tick is the difference between a long and a short
run, so start-up and compilation do not count. The best of three repeats stands in the table.
"""

import contextlib
import importlib.metadata
import importlib.util
import io
import math
import re
import resource
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

PERIOD, GAIN, LAG = 1e-3, 50.0, 0.01
NETLIST = Path(__file__).with_name("lag.cir")


def by_hand(ticks: int) -> float:
    """Return the plant's output in the last tick, from a loop in plain Python."""
    decay = math.exp(-PERIOD / LAG)
    controller = plant = answer = 0.0
    for _ in range(ticks + 1):
        answer = plant
        error = 1.0 - plant
        plant = decay * plant + (1.0 - decay) * controller
        controller += GAIN * PERIOD * error
    return answer


def proofmass_loop(engine: str) -> Callable[[int], float]:
    """Return the loop as a graph, run by an engine."""
    from proofmass import Graph, simulate
    from proofmass.blocks import Difference, DiscreteIntegrator, LowPass, Step

    graph = Graph(
        name="integral control of a lag",
        rate="1 kHz",
        blocks={
            "setpoint": Step(start_time=0.0),
            "error": Difference(),
            "controller": DiscreteIntegrator(gain=GAIN, output_unit="1"),
            "plant": LowPass(corner_frequency=1.0 / (2.0 * math.pi * LAG)),
        },
        wires=[
            "setpoint.output -> error.first",
            "plant.output -> error.second",
            "error.output -> controller.input",
            "controller.output -> plant.input",
        ],
        probes=["plant.output"],
    )
    return lambda ticks: float(simulate(graph, samples=ticks + 1, engine=engine)["plant.output"].values[-1])


def python_control(ticks: int) -> float:
    """Return the answer of one linear system in python-control; nonlinear loops take its slower `interconnect`."""
    import control
    import numpy as np

    plant = control.sample_system(control.tf([1.0], [LAG, 1.0]), PERIOD, method="zoh")
    controller = control.tf([GAIN * PERIOD], [1.0, -1.0], PERIOD)
    response = control.step_response(control.feedback(controller * plant), T=np.arange(ticks + 1) * PERIOD)
    return float(response.outputs[-1])


def pathsim_loop(ticks: int) -> float:
    """Return the answer of pathsim with its default solver at ten steps a tick."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import PT1, Adder, Amplifier, Constant, DiscreteIntegrator, Scope

    setpoint, error, gain = Constant(1.0), Adder("+-"), Amplifier(GAIN)
    controller, plant, scope = DiscreteIntegrator(T=PERIOD), PT1(K=1.0, T=LAG), Scope(sampling_period=PERIOD)
    wires = [
        Connection(setpoint, error[0]),
        Connection(plant, error[1], scope),
        Connection(error, gain),
        Connection(gain, controller),
        Connection(controller, plant),
    ]
    simulation = Simulation([setpoint, error, gain, controller, plant, scope], wires, dt=PERIOD / 10, log=False)
    simulation.run(ticks * PERIOD)
    return float(scope.read()[1][0][-1])


def bdsim_loop(ticks: int) -> float:
    """Return the answer of bdsim, whose clock ticks first after one period."""
    import bdsim

    simulation = bdsim.BDSim(graphics=False, progress=False)
    diagram = simulation.blockdiagram()
    clock = diagram.clock(1000, "Hz")
    setpoint, error = diagram.CONSTANT(1.0), diagram.SUM("+-")
    controller = diagram.INTEGRATOR_S(clock, gain=GAIN)
    plant = diagram.LTI_SISO(1.0, [LAG, 1.0])
    diagram.connect(setpoint, error[0])
    diagram.connect(plant, error[1])
    diagram.connect(error, controller)
    diagram.connect(controller, plant)
    diagram.compile()
    return float(simulation.run(diagram, T=ticks * PERIOD, watch=[plant]).y[-1, 0])


def drake_loop(ticks: int) -> float:
    """Return the answer of Drake, whose updates act from their own tick on."""
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.primitives import (
        Adder,
        ConstantVectorSource,
        DiscreteTimeIntegrator,
        FirstOrderLowPassFilter,
        Gain,
        LogVectorOutput,
    )

    builder = DiagramBuilder()
    setpoint, minus = builder.AddSystem(ConstantVectorSource([1.0])), builder.AddSystem(Gain(k=-1.0, size=1))
    error, gain = builder.AddSystem(Adder(2, 1)), builder.AddSystem(Gain(k=GAIN, size=1))
    controller = builder.AddSystem(DiscreteTimeIntegrator(1, PERIOD))
    plant = builder.AddSystem(FirstOrderLowPassFilter(time_constant=LAG, size=1))
    builder.Connect(setpoint.get_output_port(), error.get_input_port(0))
    builder.Connect(plant.get_output_port(), minus.get_input_port())
    builder.Connect(minus.get_output_port(), error.get_input_port(1))
    builder.Connect(error.get_output_port(), gain.get_input_port())
    builder.Connect(gain.get_output_port(), controller.get_input_port())
    builder.Connect(controller.get_output_port(), plant.get_input_port())
    log = LogVectorOutput(plant.get_output_port(), builder, PERIOD)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(ticks * PERIOD)
    return float(log.FindLog(simulator.get_context()).data()[0, -1])


def spice_loop(ticks: int) -> float:
    """Return the answer of ngspice: the netlist of docs/coming-from/spice.md with another end."""
    netlist = NETLIST.read_text(encoding="utf-8").replace("100m", f"{ticks}m")
    command = ["ngspice", "-b"]
    done = subprocess.run(command, input=netlist, capture_output=True, text=True, check=True)
    return float(re.search(r"^answer\s+=\s+(\S+)", done.stdout, re.MULTILINE)[1])  # type: ignore[index]


class Tool(NamedTuple):
    """A tool: its name in the table, what must be there for it, the loop in it, and the ticks of its long run."""

    name: str
    needs: str
    make: Callable[[], Callable[[int], float]]
    ticks: int


TOOLS = (
    Tool("proofmass, compiled", "proofmass", lambda: proofmass_loop("compiled"), 1_000_000),
    Tool("proofmass, plain Python", "proofmass", lambda: proofmass_loop("python"), 20_000),
    Tool("loop by hand in Python", "math", lambda: by_hand, 500_000),
    Tool("python-control, one linear system", "control", lambda: python_control, 200_000),
    Tool("Drake", "pydrake", lambda: drake_loop, 20_000),
    Tool("ngspice", "ngspice", lambda: spice_loop, 2_000),
    Tool("bdsim", "bdsim", lambda: bdsim_loop, 2_000),
    Tool("pathsim", "pathsim", lambda: pathsim_loop, 400),
)


def version(needs: str) -> str | None:
    """Return the version of what a tool needs, empty if it has none, or None if it is not installed."""
    if importlib.util.find_spec(needs) is None:
        program = shutil.which(needs)
        answer = program and subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout
        return answer and (re.findall(r"-([\d.]+)", answer) or [""])[0]
    try:
        return importlib.metadata.version({"pydrake": "drake"}.get(needs, needs))
    except importlib.metadata.PackageNotFoundError:
        return ""


def seconds(run: Callable[[int], float], ticks: int) -> float:
    """Return the CPU time of a run, that of other programs it starts included."""
    start = cpu_time()
    run(ticks)
    return cpu_time() - start


def cpu_time() -> float:
    """Return the CPU time of this process and of the programs it has run."""
    used = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def main() -> None:
    """Print the table, in the form of the page of benchmarks."""
    print("| tool | ns of CPU a tick | output after 0.1 s |\n|---|---|---|")
    for tool in TOOLS:
        number = version(tool.needs)
        if number is None:
            print(f"| {tool.name} | not installed | |")
            continue
        short = tool.ticks // 10
        with contextlib.redirect_stdout(io.StringIO()):  # some tools print what they do
            run = tool.make()
            answer = run(100)
            best = min(seconds(run, tool.ticks) for _ in range(3)) - min(seconds(run, short) for _ in range(3))
        cost = float(f"{best / (tool.ticks - short) * 1e9:.2g}")
        name, _, what = tool.name.partition(",")
        print(f"| {f'{name} {number}'.strip()}{',' * bool(what)}{what} | {cost:,.0f} | {answer:.10f} |", flush=True)


if __name__ == "__main__":
    main()
