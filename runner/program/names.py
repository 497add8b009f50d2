"""Names of the values, variables and arrays of a function in printed texts."""

import re
from collections.abc import Collection

from proofmass.runner.program.form import Storage, Value, Variable

_NAMELESS = "t"


class ProgramNames:
    """A different name for each thing asked for: its name in the program if that is free."""

    def __init__(self, reserved: Collection[str] = ()) -> None:
        self._counts = dict.fromkeys(reserved, 1)
        self._names: dict[Value | Variable | Storage, str] = {}

    def __getitem__(self, item: Value | Variable | Storage) -> str:
        if item not in self._names:
            self._names[item] = self.free(re.sub(r"\W", "_", item.name, flags=re.ASCII) or _NAMELESS)
        return self._names[item]

    def free(self, wanted: str) -> str:
        """Return a free name like the wanted one, and reserve it."""
        name = wanted
        while name in self._counts:
            self._counts[wanted] += 1
            name = f"{wanted}_{self._counts[wanted]}"
        self._counts[name] = 1
        return name
