"""From which points a search begins: by hand."""

from proofmass.runner.design.tune.search import _apart
from tests.by_hand.tried_points import tried


def test_starts_lie_apart_as_points_spread_evenly_do() -> None:
    """Sixteen points in a square are a quarter apart: those nearer than half of that count once."""
    places = [(0.5, 0.5), (0.6, 0.45), (0.5, 0.65), (0.45, 0.66), (0.9, 0.9), (0.1, 0.1)]
    points = [tried(place) for place in places + [(0.5, 0.5)] * 10]
    assert [tuple(at.parts) for at in _apart(points, 3)] == [places[0], places[2], places[4]]
    assert [tuple(at.parts) for at in _apart(points, 9)] == [places[0], places[2], places[4], places[5]]
