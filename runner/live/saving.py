"""Values of sliders in the graph file itself: comments and layout stay, saves can be undone."""

from collections.abc import Mapping
from pathlib import Path

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.files.toml_editor import edited
from proofmass.runner.output.export import write_whole

_MOST = 100  # saves that can be undone


class Saving:
    """The one file that a page may write, and what it held before each save."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._done: list[tuple[bytes, bytes]] = []  # before and after each save

    def __len__(self) -> int:
        """Return how many saves can be undone."""
        return len(self._done)

    def save(self, changes: Mapping[str, float | int | str]) -> None:
        """Write parameters into the file; raises `ModelError` if one cannot be edited."""
        before = self.path.read_bytes()
        try:
            after = edited(before.decode(), changes, str(self.path)).encode()
        except ValueError as error:
            hint = "cure the file first; the sliders stay as they are"
            raise Problem(message=f"not TOML: {error}", file=str(self.path), hint=hint).error from None
        write_whole(self.path, after)
        self._done = [*self._done, (before, after)][-_MOST:]

    def undo(self) -> None:
        """Take back the last save; raises `ModelError` if others have written the file since."""
        if not self._done:
            return
        before, after = self._done[-1]
        if self.path.read_bytes() != after:
            hint = "undo in your editor; the page goes on from the file as it is"
            raise Problem(message="has changed since it was saved from the page", file=str(self.path), hint=hint).error
        write_whole(self.path, before)
        del self._done[-1]
