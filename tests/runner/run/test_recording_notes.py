"""Notes on recordings that do not fit their run."""

from fractions import Fraction

import pytest

from proofmass.runner.run.recording_notes import _told


@pytest.mark.parametrize(
    ("times", "end", "said"),
    [
        ((0.0, 0.1, 0.2), Fraction(1, 5), []),
        ((0.0, 0.1, 0.2), None, []),
        ((-0.1, 0.0, 0.1), Fraction(1, 5), []),  # one step more is held as any value is
        ((0.05, 0.15), Fraction(1, 5), ["the recording begins at 0.05 s"]),
        ((0.0, 0.1), Fraction(1, 4), ["the recording ends at 0.1 s"]),
    ],
)
def test_a_recording_that_covers_the_run_has_none(times: tuple[float, ...], end: Fraction, said: list[str]) -> None:
    assert [message.partition(":")[0].partition(",")[0] for message, _ in _told(times, end)] == said
