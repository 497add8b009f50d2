"""Numbers in wires and registers: their ranges, bits, and names in hardware."""

from collections.abc import Iterable
from dataclasses import dataclass

from proofmass.runner.fixed.integer_interval import signed_width


@dataclass(frozen=True)
class Word:
    """Every integer from `low` to `high`, each times 2**-fraction."""

    low: int
    high: int
    fraction: int = 0

    @property
    def signed(self) -> bool:
        """Return whether it is two's complement; otherwise it has no sign bit."""
        return self.low < 0

    @property
    def width(self) -> int:
        """Bits of the wire.

        >>> Word(-128, 127).width, Word(0, 255).width, Word(0, 0).width
        (8, 8, 1)
        """
        return max(signed_width(self.low, self.high) - (not self.signed), 1)

    def holds(self, low: int, high: int) -> bool:
        """Return whether it holds every integer of an interval."""
        return self.low <= low and high <= self.high

    def __str__(self) -> str:
        return f"({self.width}, {self.fraction}){'' if self.signed else ' unsigned'}"


@dataclass(frozen=True)
class VerilogPort:
    """A port of a module: its name in Verilog, and the text by which Python calls the number: "out[3]", "error"."""

    name: str
    text: str
    word: Word
    unit: str = "1"
    doc: str = ""


@dataclass(frozen=True)
class Register:
    """A register of a module: "x.total", or an entry of a buffer as "history[3]"; `start` is its value at reset."""

    name: str
    text: str
    word: Word
    start: int


_RESERVED = """
    always and assign automatic begin buf bufif0 bufif1 case casex casez cell cmos config deassign default defparam
    design disable edge else end endcase endconfig endfunction endgenerate endmodule endprimitive endspecify endtable
    endtask event for force forever fork function generate genvar highz0 highz1 if ifnone incdir include initial inout
    input instance integer join large liblist library localparam macromodule medium module nand negedge nmos nor
    noshowcancelled not notif0 notif1 or output parameter pmos posedge primitive pull0 pull1 pulldown pullup
    pulsestyle_onevent pulsestyle_ondetect rcmos real realtime reg release repeat rnmos rpmos rtran rtranif0 rtranif1
    scalared showcancelled signed small specify specparam strong0 strong1 supply0 supply1 table task time tran tranif0
    tranif1 tri tri0 tri1 triand trior trireg unsigned use vectored wait wand weak0 weak1 while wire wor xnor xor
    bit byte do final int logic shortint longint new null priority program property ref return sequence string struct
    super this type union unique var void with
    """  # words of Verilog-2001, and those of SystemVerilog that could be names of ports
_KEYWORDS = frozenset(_RESERVED.split())


class VerilogNames:
    """Names of one module, each unique; underscores replace or follow what Verilog does not allow.

    >>> names = VerilogNames(["clock"])
    >>> names.add("x.total"), names.add("history[3]"), names.add("output"), names.add("clock")
    ('total', 'history_3', 'output_', 'clock_')
    """

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = set(taken)

    def add(self, text: str) -> str:
        """Return a name for a value that Python or the graph calls `text`."""
        plain = text.removeprefix("x.").replace("[", "_").replace("]", "").replace(".", "_")
        name = "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in plain)
        if name[:1].isdigit():
            name = f"_{name}"
        while name in self._taken or name in _KEYWORDS:
            name += "_"
        self._taken.add(name)
        return name
