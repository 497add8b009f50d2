"""Completion for shells: graphs, kinds of blocks, parameters, outputs and codes.

Nothing of a user's is run for it: parameters of blocks that need `--blocks` are not completed.
"""

import os
from collections.abc import Callable, Iterable
from pathlib import Path

import click
from click.shell_completion import BashComplete, CompletionItem, add_completion_class, split_arg_string

from proofmass.graphs.files.library import LIBRARY, file_of, library_files

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def graphs(incomplete: str, ending: str = ".toml") -> list[CompletionItem]:
    """Files and folders that begin so, and graphs of the library."""
    names = [f"{LIBRARY}{Path(name).stem}" for name in library_files() if name.endswith(ending)]
    from_library = [CompletionItem(name) for name in names if incomplete and name.startswith(incomplete)]
    start = incomplete.rpartition("/")[2]
    folder = incomplete[: len(incomplete) - len(start)]  # as it was typed
    try:
        entries = sorted(Path(folder or ".").iterdir())
    except OSError:
        entries = []
    paths = [entry for entry in entries if entry.name.startswith(start) and (start or not entry.name.startswith("."))]
    files = [f"{folder}{entry.name}" for entry in paths if entry.suffix == ending and entry.is_file()]
    folders = [f"{folder}{entry.name}/" for entry in paths if entry.is_dir()]
    return [*map(CompletionItem, (*files, *folders)), *from_library]


def of_names(names: Callable[[], Iterable[str]]) -> Completer:
    """Return a completer of names that are listed when a shell asks."""
    return lambda context, parameter, incomplete: _beginning(names(), incomplete)


def parameters(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Parameters and named values of the graph of the command line, each with its equals sign."""
    return [CompletionItem(f"{item.value}=") for item in _beginning(_of_graph(context, "parameters"), incomplete)]


def outputs(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Outputs of the blocks of the graph of the command line."""
    return _beginning(_of_graph(context, "outputs"), incomplete)


def kinds() -> Iterable[str]:
    """Kinds of blocks."""
    # start-up time: only a shell that completes a kind needs them
    from proofmass.blocks.declaration.catalog import all_blocks

    return all_blocks()


def exhibits() -> Iterable[str]:
    """Graphs of the gallery."""
    return [Path(name).stem for name in library_files() if name.endswith(".toml")]


def codes() -> Iterable[str]:
    """Codes of messages."""
    from proofmass.blocks.declaration.explanations import EXPLANATIONS  # start-up time

    return [entry.code for entry in EXPLANATIONS]


def _beginning(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(name) for name in names if name.lower().startswith(incomplete.lower())]


def _of_graph(context: click.Context, what: str) -> list[str]:
    """Parameters or outputs of the graph on the command line; none if unreadable."""
    # start-up time of every other command
    from proofmass.blocks.declaration.problem import ModelError
    from proofmass.graphs.files.toml_reader import read_graph
    from proofmass.graphs.model.flatten import flatten

    # arguments are in `args` while the value of an option is missing
    words = [context.params.get("graph"), context.params.get("study"), *context.args]
    path = next((file_of(str(word)) for word in words if str(word).endswith(".toml") or LIBRARY in str(word)), None)
    try:
        graph = read_graph(path) if path else None
    except (ModelError, OSError):
        return []
    if graph is None:
        return []
    blocks = flatten(graph).blocks
    own = [*graph.values] if what == "parameters" else []
    return [*own, *(f"{name}.{port}" for name, block in blocks.items() for port in getattr(type(block), what))]


class BashCompletion(BashComplete):
    """Completion for bash, which takes words apart at colons and equals signs: the line is read whole instead."""

    source_template = BashComplete.source_template.replace(
        'COMP_WORDS="${COMP_WORDS[*]}"', 'COMP_WORDS="${COMP_LINE:0:COMP_POINT}"'
    ).replace("complete -o nosort", "complete -o nosort -o nospace")

    def get_completion_args(self) -> tuple[list[str], str]:
        """Return the words of the line as typed, and the last of them, which may be empty."""
        line = os.environ["COMP_WORDS"]
        words = split_arg_string(line)
        self._incomplete = words.pop() if words and not line[-1:].isspace() else ""
        return words[1:], self._incomplete

    def format_completion(self, item: CompletionItem) -> str:
        """Return what bash puts for the last part of the word; a space ends what is complete."""
        if item.type != "plain":
            return super().format_completion(item)
        typed = self._incomplete.partition("=")[2] if self._incomplete.startswith("--") else self._incomplete
        cut = max(typed.rfind(sign) for sign in ":=") + 1
        end = "" if item.value.endswith(("=", "/")) else " "
        return f"{item.type},{item.value[cut:]}{end}"


add_completion_class(BashCompletion)
