"""Sphinx's settings of the documentation site; docs/site/stage.py puts them beside the staged pages."""

from pathlib import Path
from typing import Any

from docs.site.texts import SCRIPTS, write_texts
from proofmass.runner.host.versions import PROOFMASS

project = "proofmass"
author = "proofmass developers"
copyright = author
version = release = PROOFMASS

extensions = ["myst_nb", "sphinx.ext.autodoc"]
source_suffix = {".md": "myst-nb"}
root_doc = "index"
exclude_patterns = ["files", "extra"]
nitpicky = False
default_role = "code"
smartquotes = False  # texts of TOML are shown with the characters that one types

myst_enable_extensions = ["attrs_inline", "deflist"]
nb_execution_raise_on_error = True
nb_execution_timeout = 120  # seconds of a notebook
nb_render_image_options = {"width": "100%"}
myst_heading_anchors = 4
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
toc_object_entries = False  # headings name them already
autodoc_member_order = "bysource"
python_use_unqualified_type_names = True
maximum_signature_line_length = 80

html_theme = "furo"
html_title = "proofmass"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["extra"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#005f99", "color-brand-content": "#005f99"},
    "dark_css_variables": {"color-brand-primary": "#6cc2f2", "color-brand-content": "#6cc2f2"},
}
pygments_style = "friendly"
pygments_dark_style = "github-dark"


def _without_text(app: Any, what: str, name: str, member: Any, skip: bool, options: Any) -> bool | None:
    """Leave out fields of named tuples, whose docstring is Python's own: the signature shows them."""
    return True if str(getattr(member, "__doc__", "")).startswith("Alias for field number") else None


def _scripts(app: Any, page: str, *_: object) -> None:
    """Give the page of the search the texts of all pages."""
    if page == "search":
        for script in SCRIPTS:
            app.add_js_file(script, priority=100)


def _texts(app: Any, error: Exception | None) -> None:
    if error is None and app.builder.name == "html":
        write_texts(Path(app.outdir))


def setup(app: Any) -> None:
    """Connect the hooks above."""
    app.connect("autodoc-skip-member", _without_text)
    app.connect("html-page-context", _scripts)
    app.connect("build-finished", _texts)
