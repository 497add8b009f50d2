"""A figure that notebooks show by themselves, whether or not pyplot is there; imported when something is drawn."""

import io

from matplotlib.figure import Figure

from proofmass.runner.output.pictures import write_figure


class ShownFigure(Figure):
    """A figure of matplotlib whose picture in a notebook is SVG."""

    def _repr_svg_(self) -> str:
        file = io.BytesIO()
        write_figure(self, file, "svg")
        text = file.getvalue().decode()
        return text[text.index("<svg") :]
