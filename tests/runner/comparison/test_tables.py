"""Tables of a comparison: words are aligned left, numbers right."""

from proofmass.runner.comparison.studies import StudyComparison
from proofmass.runner.comparison.tables import study_tables

WORDS = {"point", "measure", "limit", "unit", ""}


def test_columns_of_words_are_aligned_left() -> None:
    _, means, yields, _ = study_tables(StudyComparison((), True, (), ()))
    for table in (means, yields):
        assert {table.heads[place] for place in table.left} == WORDS & {*table.heads}
