"""The command `allan`: deviations over averaging time, and the coefficients of noise."""

from functools import partial

from proofmass.runner.analysis.allan.deviations import allan, duration
from proofmass.runner.analysis.allan.plot import plot_allan
from proofmass.runner.analysis.allan.text import allan_text, duration_text
from proofmass.runner.analysis.spectrum.series import Series
from proofmass.runner.commands.answers import Shown
from proofmass.runner.commands.declarations.analysis import AllanRequest
from proofmass.runner.commands.series_source import answers_about, quantity


def show_allan(request: AllanRequest) -> int:
    """Show the Allan deviations of signals and return the exit code."""
    return answers_about(request, request.picture, partial(_answered, request))


def _answered(request: AllanRequest, series: Series) -> Shown:
    seconds = quantity("--tau", request.tau, "s") if request.tau else None
    error = quantity("--confidence", request.confidence, "1")
    result = allan(series)
    needed = duration(result, seconds, error) if seconds is not None else None
    more = {"needed": needed.as_data()} if needed else {}
    lines = [allan_text(result), *([duration_text(needed)] if needed else [])]
    return Shown(series.name, lines, lambda: result.as_data() | more, partial(plot_allan, result))
