"""Tables of a comparison: words are aligned left, numbers right."""

import pytest

from proofmass.graphs.model.differences import GraphDifference
from proofmass.runner.comparison.studies import StudyComparison
from proofmass.runner.comparison.tables import difference_table, study_tables

WORDS = {"point", "measure", "limit", "unit", ""}


def test_columns_of_words_are_aligned_left() -> None:
    _, means, yields, _ = study_tables(StudyComparison((), True, (), ()))
    for table in (means, yields):
        assert {table.heads[place] for place in table.left} == WORDS & {*table.heads}


@pytest.mark.defect("S995", before="two equal texts, cut before the difference", after="what differs")
def test_long_texts_are_cut_about_what_differs() -> None:
    texts = [
        "signal readout.long_output_of_it, statistic settling_time, target " + end for end in ("0", "0.5, within 1")
    ]
    ((_, _, before, after, _),) = difference_table("graph", [GraphDifference("measures.end", *texts)]).rows
    assert before == "... settling_time, target 0"
    assert after == "... settling_time, target 0.5, within 1"
    ((_, _, added, gone, _),) = difference_table("graph", [GraphDifference("measures.end", texts[0] * 2)]).rows
    assert (added, gone) == (texts[0][:56] + " ...", "")
