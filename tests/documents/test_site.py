"""The site: every page is in the navigation once, links lead somewhere, the reference has everything public."""

import re
from pathlib import Path

import pytest

import proofmass
from docs.site.alive import NAME
from docs.site.gallery import gallery_pictures
from docs.site.offline import outside_addresses
from docs.site.reference_commands import commands_page
from docs.site.reference_keys import keys_page
from docs.site.reference_python import groups
from docs.site.stage import BrokenLinkError, _rewritten, navigation, repository_pages, stage
from proofmass.blocks.declaration.catalog import all_blocks
from proofmass.graphs.model.keys import STUDY_KEYS
from proofmass.graphs.model.top_keys import TOP_KEYS
from proofmass.runner.command_line import cli
from proofmass.runner.output.typeset import unwrapped

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The staged source of the site, with one diagram for all graphs: those are looked at in `test_gallery`."""
    folder = tmp_path_factory.mktemp("site") / "source"
    diagram = next(text for _, text in gallery_pictures())
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("docs.site.gallery._diagram", lambda path: diagram)
        stage(folder)
    return folder


def test_every_page_is_in_the_navigation_once(source: Path) -> None:
    names = [path.relative_to(source).as_posix() for path in source.rglob("*.md")]
    listed = [page for pages in navigation(names).values() for page in pages]
    assert len(listed) == len(set(listed))
    below = ("reference/blocks/", "gallery/", "decisions/")
    indexes = ("reference/blocks/index.md", "gallery/index.md", "decisions/README.md")
    assert {name.removesuffix(".md") for name in names} - {"index"} - set(listed) == {
        name.removesuffix(".md") for name in names if name.startswith(below) and name not in indexes
    }


def test_the_landing_page_carries_the_engine(source: Path) -> None:
    page = (source / "extra" / NAME).read_text(encoding="utf-8")
    assert "WebAssembly" in page
    assert f'src="{NAME}#controller"' in (source / "index.md").read_text(encoding="utf-8")


def test_links_of_staged_pages_lead_somewhere(source: Path) -> None:
    for page in source.rglob("*.md"):
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
            assert "://" in link or (page.parent / link).exists(), f"{page.relative_to(source)}: {link}"


def slugs(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and the site make them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", repository_pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_anchors_of_links_are_headings(page: Path) -> None:
    for link, anchor in re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" not in link:
            assert anchor in slugs((page.parent / link) if link else page), f"{link}#{anchor}"


def test_a_link_to_nothing_is_refused(tmp_path: Path) -> None:
    page = ROOT / "docs" / "margins.md"
    broken = tmp_path / "page.md"
    broken.write_text("[x](no-such-page.md)", encoding="utf-8")
    assert _rewritten(page, "margins.md", tmp_path)
    with pytest.raises((BrokenLinkError, ValueError)):
        _rewritten(broken, "page.md", tmp_path)


def test_what_a_page_loads_from_elsewhere_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<a href="https://x.org">x</a><script src="https://x.org/x.js"></script>')
    (tmp_path / "b.css").write_text("@import url(//x.org/font.css); a { background: url(data:image/png;base64,x) }")
    assert [line.partition(":")[0] for line in outside_addresses(tmp_path)] == ["a.html", "b.css"]


def test_every_block_is_in_the_reference(source: Path) -> None:
    headings = [
        heading
        for page in (source / "reference" / "blocks").glob("*.md")
        for heading in re.findall(r"^## (\w+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert sorted(headings) == sorted(all_blocks())


def test_every_command_and_every_option_is_in_the_reference() -> None:
    page = commands_page()
    for name, command in cli.commands.items():
        section = page.partition(f"## proofmass {name}\n")[2].partition("\n## ")[0]
        for parameter in command.params:
            for option in parameter.opts:
                assert option in section or option.upper() in section, (name, option)


def test_every_key_is_in_the_reference() -> None:
    page = keys_page()
    for key in (*TOP_KEYS, *STUDY_KEYS):
        assert f"| `{key}` |" in page, key


def test_every_public_name_is_in_the_reference(source: Path) -> None:
    assert sorted(name for names in groups().values() for name in names) == sorted(proofmass.__all__)
    page = (source / "reference" / "python.md").read_text(encoding="utf-8")
    for name in proofmass.__all__:
        assert f":: proofmass.{name}\n" in page


def test_every_written_page_has_one_title() -> None:
    for path in repository_pages():
        text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        assert len(re.findall(r"^# ", text, re.MULTILINE)) == 1, path


def test_full_lines_run_on_and_equations_keep_theirs() -> None:
    full = "a word " * 13
    assert unwrapped(f"x = 1\ny = 2\n\n{full}\nand more.\nz = 3") == f"x = 1\ny = 2\n\n{full} and more.\nz = 3"


def test_pictures_keep_their_letters(source: Path) -> None:
    """Their own width: 1330 pixels of a diagram, 11 inches of a plot, 1650 dots of 150 an inch."""
    pages = {
        "index.md": "loop.svg){.diagram width=1330px}",
        "tutorial/4-margins.md": "margins.svg){.plot width=1056px}",
    }
    pages["noise.md"] = "noise_quartz.png){.plot width=1056px}"
    for page, picture in pages.items():
        assert picture in (source / page).read_text(encoding="utf-8")
