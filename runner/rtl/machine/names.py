"""Names in the top module of a machine, each handed out once."""

from proofmass.runner.rtl.machine.machine import Machine, OutputNet
from proofmass.runner.rtl.machine.modules import CLOCKING
from proofmass.runner.rtl.machine.words import VerilogNames


class TopNames:
    """Names of the wires and registers of the top module itself."""

    def __init__(self, machine: Machine) -> None:
        names = VerilogNames([*CLOCKING, *(net.name for net in machine.nets.values())])
        for instance in machine.instances:
            names.add(instance.name)
        stored = [net for net in machine.nets.values() if net.kept]
        self.ticks = {stride: names.add(f"tick_{stride}") for stride in machine.strides}
        self.counts = {stride: names.add(f"count_{stride}") for stride in machine.strides}
        self.now = {net: names.add(f"{net.name}_now") for net in stored}
        self.kept = {net: names.add(f"{net.name}_kept") for net in stored}
        latest = max((each.stage for each in machine.instances if each.module.registers), default=0)
        self.ready = [names.add(f"ready_{k}") for k in range(1, latest + 1)]
        self.late = {
            net: [names.add(f"{net.name}_late_{k}") for k in range(1, n + 1)] for net, n in machine.delays.items()
        }
        self.outputs = {port.text for port in machine.outputs}
        self.given = {net: self._given(machine, net, names) for net in machine.nets.values()}

    def _given(self, machine: Machine, net: OutputNet, names: VerilogNames) -> str:
        """Name of a net at its source: of a delayed output, the last register has its name."""
        delayed = net.signal in self.outputs and machine.latency > net.stage
        return names.add(f"{net.name}_early") if delayed else net.name
