"""The facts that determine the bits of a study, as texts a ledger keeps and workers compare."""

import hashlib
import struct

from proofmass.runner.plan.planned import Plan
from proofmass.runner.run.provenance import graph_text
from proofmass.runner.studies.runs.sensor_runs import SensorRuns


def facts_of(sensors: SensorRuns) -> dict[str, str]:
    """Return hashes of graph, study, code of the blocks and, if there are any, recordings."""
    known = {"graph": graph_text(sensors.study.graph), "study": sensors.study.text(), "code": sensors.code()}
    played = _recordings(sensors.plan)
    return known | ({"recordings": played} if played else {})


def _recordings(plan: Plan) -> str:
    lines = []
    for name, buffer in sorted(plan.recorded):
        held = plan.buffers[name, buffer]
        lines.append(f"{name}.{buffer} = {hashlib.sha256(struct.pack(f'<{len(held)}d', *held)).hexdigest()}\n")
    return "".join(lines)
