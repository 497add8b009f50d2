"""Pieces of the site: equations in print, the texts for the search, cards of the gallery."""

from pathlib import Path

import pytest

from docs.site.gallery import all_exhibits, cards, diagram_of
from docs.site.texts import texts_of_pages, write_texts
from proofmass.blocks.declaration.catalog import all_blocks, facts
from proofmass.runner.output.typeset import typeset


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("w^2 = 4 pi^2 f^(n-1)", "w<sup>2</sup> = 4 π<sup>2</sup> f<sup>n−1</sup>"),
        ("x_i' = x_(i+1) - a_12 u", "x<sub>i</sub>' = x<sub>i+1</sub> - a<sub>12</sub> u"),
        ("sqrt(k / m) >= 0 and a < b", "√(k / m) ≥ 0 and a &lt; b"),
        ("v -> -e v", "v → -e v"),
        ("`t_2` is `a < b`, t_2", "<code>t_2</code> is <code>a &lt; b</code>, t<sub>2</sub>"),
        ("<script>x_1</script> `a", "&lt;script&gt;x<sub>1</sub>&lt;/script&gt; `a"),
        ("corner_frequency, spin, map_of", "corner_frequency, spin, map_of"),
    ],
)
def test_a_formula_in_print(text: str, printed: str) -> None:
    assert typeset(text) == f'<p class="prose">{printed}</p>'


def test_indented_lines_stand_apart() -> None:
    assert typeset("It is\n\n    x = 1\n    y = 2\n\nthen.") == (
        '<p class="prose">It is</p>\n<p class="display">x = 1<br>y = 2</p>\n<p class="prose">then.</p>'
    )


def test_every_equation_keeps_its_words() -> None:
    """Names of parameters and words of prose are never torn by an index or a Greek letter."""
    for kind in all_blocks().values():
        equation = facts(kind)["equation"]
        printed = typeset(equation)
        for name in kind.parameters:
            if name in equation and "_" in name:
                assert name in printed, (kind.__name__, name)


def test_the_search_has_the_text_of_each_page_once(tmp_path: Path) -> None:
    (tmp_path / "_static").mkdir()
    (tmp_path / "deep").mkdir()
    article = '<article role="main"><h1>A &amp; B</h1><svg><text>no</text></svg> is\n it</article>'
    page = f"<body><nav>menu</nav>{article}x</body>"
    (tmp_path / "deep" / "page.html").write_text(page, encoding="utf-8")
    (tmp_path / "_static" / "other.html").write_text(page, encoding="utf-8")
    assert list(texts_of_pages(tmp_path)) == [("deep/page.html", "A & B is it")]
    write_texts(tmp_path)
    script = (tmp_path / "_static" / "texts-of-pages.js").read_text(encoding="utf-8")
    assert script == 'window.textsOfPages = {"deep/page.html": "A & B is it"};\n'


def test_a_study_has_the_diagram_of_its_graph() -> None:
    named = {item.name: item for item in all_exhibits()}
    assert diagram_of(named["margin_tolerance_study"]) == "scale_factor_drift"
    lines = "\n".join(cards([named["margin_tolerance_study"]]))
    assert 'href="../gallery/margin_tolerance_study.html"' in lines
    assert 'src="../thumbnails/scale_factor_drift.svg"' in lines
