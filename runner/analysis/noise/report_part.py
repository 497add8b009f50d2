"""The noise budget of an output as a section of the report of a run: table, picture and notes."""

from html import escape

from proofmass.blocks.declaration.shown_units import in_table, prefix
from proofmass.runner.analysis.allan.field_units import field_unit, in_field_unit, word_of
from proofmass.runner.analysis.noise.noise_budget import ROWS, SMALL_MISFIT, NoiseBudget
from proofmass.runner.analysis.noise.plot import plot_noise
from proofmass.runner.output.page import broken, picture, table


def noise_section(budget: NoiseBudget) -> tuple[str, str]:
    """Return heading and HTML of a budget."""
    factor, unit = prefix(budget.unit, budget.rms)
    rows = [
        (broken(s.block), s.kind + " ?" * s.doubtful, f"{s.rms * factor:.5g}", f"{100.0 * s.share:.2f} %")
        for s in budget.sources[:ROWS]
    ]
    rows.append((broken("all"), "", f"{budget.rms * factor:.5g}", "100 %"))
    low, high = budget.band
    about = f"<p>{low:g} Hz to {high:g} Hz, about the operating point of the graph without noise.</p>"
    heads = ("source", "kind", f"rms {escape(unit)}".strip(), "share of the mean square")
    drawing = picture(plot_noise(budget), f"noise of {budget.output}")
    notes = "".join(f"<p>{escape(note)}</p>" for note in budget.notes)
    html = about + table(heads, rows, numbers=(2, 3)) + _coefficients(budget) + notes
    return f"Noise of {budget.output}", f'{html}<div class="wide">{drawing}</div>'


def _coefficients(budget: NoiseBudget) -> str:
    """Return the table of N, B, K and Q, where they describe the density."""
    levels, unit = budget.levels, budget.referred_unit
    if levels.misfit > SMALL_MISFIT:
        return ""
    known = ((level.name, in_field_unit(level.name, level.value, unit)) for level in levels.levels if level.value)
    rows = [(name, word_of(name, unit), f"{value:.5g}", in_table(field_unit(name, unit))) for name, value in known]
    return table(("", f"at {broken(budget.input or budget.output)}", "value", "unit"), rows, numbers=(2,))
