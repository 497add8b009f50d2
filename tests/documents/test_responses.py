"""Pictures of what blocks answer: curves of their examples, on the pages of the site."""

import re

import pytest

from docs.site.reference_blocks import _block
from docs.site.responses import response_picture
from proofmass.blocks import Integrator, Negation, RecordedSignal, VectorJoin
from proofmass.blocks.declaration.catalog import all_blocks


def curves(picture: str) -> dict[str, list[float]]:
    """Heights of each curve by the name beside it, less the top of its panel."""
    found = {}
    frame = r'y="(\d+)" width="\d+" height="46"/>'
    label = r'<text class="port".*?>(\w+)</text>'
    panel = frame + r"\n" + label + r'\n.*\n<path class="\w+" d="M\d+ [\d.]+(.*)"/>'
    for top, name, steps in re.findall(panel, picture):
        found[name] = [float(y) - float(top) for y in re.findall(r"V([\d.]+)", steps)]
    return found


def test_a_negation_is_its_input_upside_down() -> None:
    drawn = curves(response_picture(Negation))
    assert len(drawn["input"]) == len(drawn["output"]) == 201
    sums = [one + other for one, other in zip(drawn["input"], drawn["output"], strict=True)]
    assert sums == pytest.approx([46.0] * 201, abs=0.11)


def test_an_integral_is_largest_where_its_input_turns_negative() -> None:
    """Heights go downwards: the highest place of the integral of a sine of 130 Hz is at half its period."""
    drawn = curves(response_picture(Integrator))
    top = min(range(78), key=drawn["output"].__getitem__)
    assert top == pytest.approx(10_000 / 130.0 / 2.0, abs=1.0)


def test_pages_have_it_and_a_block_that_plays_a_file_has_none() -> None:
    assert response_picture(RecordedSignal) == ""
    assert any(line.count('<svg class="response"') for line in _block(VectorJoin, responses=True))
    assert not any("response" in line for line in _block(VectorJoin, responses=False))


@pytest.mark.exhaustive
def test_every_block_has_a_picture() -> None:
    missing = [name for name, kind in all_blocks().items() if not curves(response_picture(kind))]
    assert missing == ["RecordedSignal"]
