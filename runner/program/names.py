"""Names for the values, variables and arrays of a function, in texts that are printed from it."""

import re
from collections.abc import Collection

from proofmass.runner.program.form import Array, Value, Variable

_NAMELESS = "t"


class Names:
    """A name for everything that is asked for, each another; that of the program where it is free."""

    def __init__(self, reserved: Collection[str] = ()) -> None:
        self._counts = dict.fromkeys(reserved, 1)
        self._names: dict[Value | Variable | Array, str] = {}

    def __getitem__(self, item: Value | Variable | Array) -> str:
        if item not in self._names:
            self._names[item] = self.free(re.sub(r"\W", "_", item.name, flags=re.ASCII) or _NAMELESS)
        return self._names[item]

    def free(self, wanted: str) -> str:
        """A name like the one that is wanted, taken from now on."""
        name = wanted
        while name in self._counts:
            self._counts[wanted] = self._counts.get(wanted, 1) + 1
            name = f"{wanted}_{self._counts[wanted]}"
        self._counts[name] = 1
        return name
