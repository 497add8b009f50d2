"""A figure that notebooks show by themselves, whether or not pyplot is there; imported when something is drawn."""

from collections.abc import Callable

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure of matplotlib whose picture in a notebook is SVG, made by `drawn`."""

    drawn: Callable[["ShownFigure"], str]

    def _repr_svg_(self) -> str:
        return self.drawn(self)
