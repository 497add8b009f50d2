"""Provenance of a result: versions, processor, and a hash of the graph."""

import hashlib
import platform
from datetime import UTC, datetime

from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.host.versions import PROOFMASS, version
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.run.engine_table import ENGINES


def graph_hash(graph: Graph) -> str:
    """SHA-256 of the graph as text: the same for every order of declaration."""
    return hashlib.sha256(graph_text(graph).encode()).hexdigest()


def graph_text(graph: Graph) -> str:
    """The graph in its written form, the probes in alphabetical order like everything else."""
    return write_graph(graph.changed(probes=tuple(sorted(graph.probes))))


def integration_of(planned: Plan) -> str:
    """Return in words how the groups of continuous blocks are integrated; empty without them."""
    return "; ".join(f"{', '.join(s.group.blocks)}: {_method(s)}" for s in planned.solvers)


def _method(solver: Solver) -> str:
    if solver.exact:
        return "exact" + (", matrices made anew as parameters or factors move" if solver.renewed else "")
    if solver.tolerance:
        return f"{solver.method}, steps chosen for {solver.tolerance:g}"
    steps = f"{solver.substeps} step{'s' if solver.substeps > 1 else ''} a tick"
    return f"{solver.method}, {steps}, whose error is not watched"


def provenance(graph: Graph, engine: str, integration: str = "", handed_over: int | None = None) -> dict[str, str]:
    """Facts to repeat a run: what ran, where, when; `engine` is empty for runs that were kept, by
    whichever engine.

    `handed_over` is the tick at which machine code took over from plain Python; no digest has it.
    """
    libraries = ENGINES[engine].libraries if engine else ("numpy",)
    return {
        "graph_hash": graph_hash(graph),
        "engine": engine,
        **({"handed_over": f"by plain Python at tick {handed_over}"} if handed_over is not None else {}),
        **({"integration": integration} if integration else {}),
        "proofmass": PROOFMASS,
        "python": platform.python_version(),
        **{library: version(library) for library in libraries},
        "platform": platform.platform(),
        "processor": _processor(engine),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _processor(engine: str) -> str:
    """Return the processor that the loop was compiled for, or the kind of machine where nothing was compiled."""
    if not engine or not ENGINES[engine].machine_code:
        return platform.machine()
    # for start-up time: plain Python needs no compiler
    from llvmlite.binding import get_host_cpu_name

    return str(get_host_cpu_name())
