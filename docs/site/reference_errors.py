"""The page of codes: what is behind each kind of fault, from the table that `proofmass explain` prints."""

from proofmass.blocks.declaration.explanations import EXPLANATIONS


def errors_page() -> str:
    """Return the page of all codes."""
    lines = [
        "# Codes of faults",
        "",
        "`proofmass explain P0301` prints an entry. Commands name the codes of what they refuse.",
        "",
    ]
    for entry in EXPLANATIONS:
        lines += [f"## {entry.code}: {entry.title}", "", entry.cause, "", entry.cure, ""]
    return "\n".join(lines)
