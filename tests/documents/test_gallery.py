"""The page of the gallery: its pictures are what `draw` makes, and its sensors are those of the library."""

import pytest

from tests.documents.pictures import DOCS, PICTURES, drawn


def test_there_are_pictures() -> None:
    assert len(PICTURES) == 10


@pytest.mark.parametrize(("path", "name"), PICTURES, ids=[name for _, name in PICTURES])
def test_a_picture_is_what_draw_makes(path: str, name: str) -> None:
    message = "python -m tests.documents.pictures draws it anew"
    assert (DOCS / path).read_text(encoding="utf-8") == drawn(name), message
