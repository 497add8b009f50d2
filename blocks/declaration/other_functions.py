"""Functions by their names in other tools, for Python and for the command line."""

from collections.abc import Mapping

FUNCTIONS: Mapping[str, tuple[str, ...]] = {  # what others call them; "-" also stands for "_"
    "read_graph": ("load", "open", "read", "load-graph", "open-graph", "read-toml", "from-toml", "load-toml"),
    "write_graph": ("save", "write", "dump", "save-graph", "to-toml", "write-toml"),
    "simulate": ("run", "sim", "simulation", "start", "execute", "exec", "go", "transient", "tran", "trace"),
    "sweep": ("scan", "parameter-sweep"),
    "check": ("lint", "validate", "compile", "build", "inspect"),
    "margins": ("bode", "nyquist", "stability", "poles", "root-locus", "loop", "margin", "stability-margins"),
    "linearise": ("linearize", "state-space"),
    "response": ("step", "frequency", "bandwidth", "transfer", "impulse", "freqresp", "frequency-response"),
    "noise": ("noise-budget", "budget"),
    "spectrum": ("psd", "fft", "welch", "periodogram"),
    "tones": ("thd", "enob", "snr", "sfdr"),
    "allan": ("adev", "oadev", "allan-deviation"),
    "run_study": ("montecarlo", "monte-carlo", "mc", "study", "population", "drift", "yield"),
    "worst": ("worst-case", "corners", "tolerance", "tolerances", "wca"),
    "tune": ("optimise", "optimize", "autotune", "design"),
    "fit": ("identify", "calibrate", "estimate", "sysid"),
    "prove": ("proof", "robust", "robstab"),
}
_PICTURES = ("plot", "draw", "show", "figure", "picture")


def drawn_by(name: str) -> str:
    """Return how a picture is made, if the name asks for one; else an empty text."""
    return "a result draws itself, as simulate(graph).plot()" if name in _PICTURES else ""


def function_of(name: str) -> str:
    """Return the function that is called so here or in other tools; empty if there is none."""
    if name in FUNCTIONS:
        return name
    folded = name.lower().replace("_", "-")
    return next((function for function, others in FUNCTIONS.items() if folded in others), "")
