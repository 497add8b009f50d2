"""Parts in percent."""

import pytest

from proofmass.runner.studies.shown.report_sections import percent_text


@pytest.mark.parametrize(
    ("part", "text"),
    [(0.0, "0 %"), (1.0, "100 %"), (0.5, "50.0 %"), (0.9996, "99.96 %"), (0.99996, "100 %"), (4e-5, "0 %")],
)
def test_parts_of_nearly_nothing_and_nearly_all_have_more_digits(part: float, text: str) -> None:
    assert percent_text(part) == text
