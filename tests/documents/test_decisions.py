"""Decision records: numbered without a gap, of one form, all in the index."""

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "decisions"
RECORDS = sorted(FOLDER.glob("[0-9]*.md"))
SECTIONS = ["Context", "Decision", "Measurement", "Consequence"]


def test_numbers_have_no_gap() -> None:
    assert [int(path.name[:4]) for path in RECORDS] == list(range(1, len(RECORDS) + 1))


@pytest.mark.parametrize("path", RECORDS, ids=lambda path: path.stem)
def test_a_record_has_title_date_status_and_four_sections(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    title, status = re.match(r"# (\d{4} .+)\n\n(.+(?:\n.+)*)\n", text).groups()  # type: ignore[union-attr]
    assert title.startswith(path.name[:4])
    assert re.match(r"\d{4}-\d\d-\d\d, (accepted|superseded)", status)
    assert re.findall(r"^## (.+)$", text, re.MULTILINE) == SECTIONS


def test_the_index_lists_every_record_with_its_title_and_status() -> None:
    rows = re.findall(
        r"^\| \[\d{4}\]\((.+?)\) \| (.+?) \| (.+?) \| (.+?) \|$", (FOLDER / "README.md").read_text(), re.M
    )
    assert [row[0] for row in rows] == [path.name for path in RECORDS]
    for name, title, date, status in rows:
        text = (FOLDER / name).read_text(encoding="utf-8")
        assert text.startswith(f"# {name[:4]} {title}\n\n{date}, {status}"), name
