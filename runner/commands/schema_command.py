"""The command `schema`: the JSON Schemas of graph and study files."""

import json
from pathlib import Path

from proofmass.graphs.schema.schema import graph_schema, study_file_schema
from proofmass.runner.commands.answers import DONE, write_or_print
from proofmass.runner.commands.declarations.graphs import SchemaRequest
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.host.named_files import write_text

SCHEMA_FILE, STUDY_SCHEMA_FILE = "proofmass-graph.json", "proofmass-study.json"  # in the first lines of files


def write_schema_file(path: Path) -> None:
    """Write the schema of that name to a file, without space."""
    schema = study_file_schema() if path.name == STUDY_SCHEMA_FILE else graph_schema()
    write_text(path, json.dumps(schema, separators=(",", ":")) + "\n")


def write_schema(request: SchemaRequest) -> int:
    """Write a schema to a file, or print it, and return the exit code."""
    schema = study_file_schema() if request.study else graph_schema(own_blocks(request.own))
    write_or_print(json.dumps(schema, separators=(",", ":")), request.output)
    return DONE
