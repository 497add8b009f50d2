"""The pages of the reference, made from the code: blocks, Python, commands, keys."""

from collections.abc import Iterator

from docs.site.markdown import table
from docs.site.reference_blocks import block_pages
from docs.site.reference_commands import commands_page
from docs.site.reference_errors import errors_page
from docs.site.reference_keys import keys_page
from docs.site.reference_python import python_page


def contents() -> str:
    """Return the list of the generated pages, for the page about them."""
    rows = [
        ("[Blocks](blocks/index.md)", "every block by family: ports, equation, parameters, an example"),
        ("[Python](python.md)", "every public name with its arguments"),
        ("[Command line](commands.md)", "every command with its options"),
        ("[Keys](keys.md)", "every key of graph files and studies"),
        ("[Codes of faults](errors.md)", "cause and cure of what commands refuse"),
    ]
    return "\n".join(table(("page", "has"), rows))


def reference_pages(responses: bool = False) -> Iterator[tuple[str, str]]:
    """Yield the name and the text of each generated page, blocks with pictures of their responses or without."""
    yield from block_pages(responses)
    yield "reference/python.md", python_page()
    yield "reference/commands.md", commands_page()
    yield "reference/keys.md", keys_page()
    yield "reference/errors.md", errors_page()
