"""The command `allan`: deviations over averaging time, and the coefficients of noise."""

from proofmass.runner.analysis.allan.deviations import allan, duration
from proofmass.runner.analysis.allan.plot import plot_allan
from proofmass.runner.analysis.allan.text import allan_text, duration_text
from proofmass.runner.commands.answers import DONE, print_answer, print_picture
from proofmass.runner.commands.declarations.analysis import AllanRequest
from proofmass.runner.commands.series_source import quantity, signal_of


def show_allan(request: AllanRequest) -> int:
    """Show the Allan deviation of a signal and return the exit code."""
    seconds = quantity("--tau", request.tau, "s") if request.tau else None
    error = quantity("--confidence", request.confidence, "1")
    result = allan(signal_of(request))
    needed = duration(result, seconds, error) if seconds is not None else None
    more = {"needed": needed.as_data()} if needed else {}
    lines = [allan_text(result), *([duration_text(needed)] if needed else [])]
    print_answer(request.as_json, lambda: result.as_data() | more, lines)
    print_picture(lambda: plot_allan(result), request.picture, request.as_json)
    return DONE
