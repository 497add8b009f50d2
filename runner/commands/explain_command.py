"""The command `explain`: what is behind a code of a message."""

import click

from proofmass.blocks.declaration.explanations import EXPLANATIONS
from proofmass.blocks.declaration.problem import did_you_mean
from proofmass.runner.commands.answers import DONE, print_json, print_text
from proofmass.runner.commands.declarations.blocks import ExplainRequest


def explain_codes(request: ExplainRequest) -> int:
    """Print entries of codes, or all, and return the exit code; raises `click.UsageError`."""
    known = {entry.code: entry for entry in EXPLANATIONS}
    wanted = [code.upper() for code in request.code]
    for code in wanted:
        if code not in known:
            raise click.UsageError(f"there is no code {code}; {did_you_mean(code, known, 'the codes')}")
    entries = [known[code] for code in wanted or known]
    if request.as_json:
        print_json([entry._asdict() for entry in entries])
    elif wanted:
        told = (f"{one.code}: {one.title}\n  cause:    {one.cause}\n  cure:     {one.cure}" for one in entries)
        print_text(["\n\n".join(told)])
    else:
        print_text(f"{entry.code}  {entry.title}" for entry in entries)
    return DONE
