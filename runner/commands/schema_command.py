"""The command `schema`: the JSON Schema of graph files."""

import json
from pathlib import Path

from proofmass.graphs.schema.schema import schema
from proofmass.runner.commands.answers import write_or_print
from proofmass.runner.commands.declarations.graphs import SchemaRequest
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.own_blocks import own_blocks

SCHEMA_FILE = "proofmass-graph.json"  # the name in the first line of graphs of the library


def write_schema_file(path: Path, own: Path | None) -> None:
    """Write the schema to a file."""
    path.write_text(json.dumps(schema(own_blocks(own))) + "\n", encoding="utf-8")  # without space, a third of the size


def write_schema(request: SchemaRequest) -> int:
    """Write the schema to a file, or print it, and return the exit code."""
    write_or_print(json.dumps(schema(own_blocks(request.own)), indent=2), request.output)
    return DONE
