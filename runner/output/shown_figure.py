"""A figure that notebooks show by themselves, whether or not pyplot is there; imported when something is drawn."""

from collections.abc import Callable
from inspect import ismethod
from typing import Any

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure of matplotlib whose picture in a notebook is SVG, made by `drawn`."""

    drawn: Callable[["ShownFigure"], str]

    def draw(self, renderer: Any) -> None:
        """Draw a figure, or lay it out alone where drawing is disabled.

        Before it writes a figure, matplotlib asks for the layout by a whole draw in vain, by a
        renderer whose methods are replaced: a fourth of the time of a picture.
        """
        layout = self.get_layout_engine()
        if layout is not None and not ismethod(renderer.open_group):
            layout.execute(self)
        else:
            super().draw(renderer)

    def _repr_svg_(self) -> str:
        return self.drawn(self)
