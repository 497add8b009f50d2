"""Ticks of a loop that is cut at one wire, each a linear map of its own.

Every number that lasts gets a direction of its own before each tick, so that its slopes afterwards are the map of that
tick alone: a matrix of few entries, whatever the length of the period.
"""

from collections.abc import Collection
from collections.abc import Set as AbstractSet
from typing import Any, NamedTuple

from proofmass.runner.derivatives.dual import dual, slopes_of, value_of
from proofmass.runner.derivatives.dual_plan import SIGNALS
from proofmass.runner.derivatives.dual_ticks import DualTicks, Place
from proofmass.runner.plan.memory import Rows

_LASTING = object()  # marks directions of numbers that last


class TickMap(NamedTuple):
    """Slopes of the numbers that last, and of the wire; None in a tick without a value of it."""

    moved: dict[Place, dict[Place, float]]
    entered: dict[Place, float]  # by the input
    read: dict[Place, float] | None  # the output, before the input is added


class UndefinedSlopesError(ArithmeticError):
    """Slopes of numbers that last lead to none: bits of them are read, or they choose places in arrays."""

    def __init__(self, places: Collection[Place]) -> None:
        super().__init__("what lasts has no derivative")
        self.blocks = frozenset(of if isinstance(of, str) else of[0] for _, of, _ in places)


class SteppedTicks(DualTicks):
    """Ticks with the input and the output at the same wire, which is cut there; what it moves is in some blocks."""

    def __init__(self, *arguments: Any, moving: AbstractSet[str]) -> None:
        self.ticks: list[TickMap] = []
        super().__init__(*arguments)
        self._blocks = moving
        self.live = set(self._renewed())  # numbers that last and have slopes

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `TickError`."""
        (node,) = self.recorded
        while self._memory.tick < last:
            before = len(self.recorded[node])
            super().advance(self._memory.tick + 1, rows)
            read = [self._by_places(slopes_of(value, SIGNALS))[0] for value in self.recorded[node][before:]]
            moved, entered = dict[Place, dict[Place, float]](), dict[Place, float]()
            had = self._renewed()
            for place, slopes in had.items():
                moved[place], by_input = self._by_places(slopes)
                if by_input:
                    entered[place] = by_input
            self.ticks.append(TickMap(moved, entered, read[0] if read else None))
            self.live = set(had)
        return True

    def _by_places(self, slopes: Any) -> tuple[dict[Place, float], float]:
        """Return slopes by the numbers that lasted, and that by the input of this tick."""
        own = {key[1]: slope for key, slope in slopes.items() if key[0] is _LASTING}
        return own, sum(slope for key, slope in slopes.items() if key[0] is not _LASTING)

    def _renewed(self) -> dict[Place, Any]:
        """Give each number that lasts a direction of its own, and return the slopes that it had."""
        had: dict[Place, Any] = {}

        def renewed(place: Place, value: Any) -> Any:
            slopes = slopes_of(value, SIGNALS)
            if not slopes:
                return value
            had[place] = slopes
            return dual(value_of(value, SIGNALS), {(_LASTING, place): 1.0}, SIGNALS)

        self.replace_lasting(renewed)
        return had
