"""The typed program: functions and plans are lowered into it, and targets print from it.

A program is structured: functions of statements, `If`, `For`, `While`; no jumps but `Break`,
`Continue` and `Return`. One statement computes a `Value`, once; only later statements read it, in
the same region or in one inside it. What changes is a `Variable`, read by `Get` and written by
`Set`, or an entry of a `Storage`. Every value has a kind; lowering dissolves tuples and NamedTuples
into numbers. Each statement knows the line of Python that it comes from.

Arithmetic is that of the reference: one rounding an operation, in the order written, no
contraction; integers of 64 bits in two's complement. A program is checked by `verify` and read by
`listing`.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple, TypeAlias


class Kind(Enum):
    """Type of a value: a binary64 number, a 64-bit integer, or a truth value (one byte where it stands in an array)."""

    FLOAT = "f64"
    INTEGER = "i64"
    TRUTH = "bool"


FLOAT, INTEGER, TRUTH = Kind.FLOAT, Kind.INTEGER, Kind.TRUTH


class Line(NamedTuple):
    """A line of Python that a statement comes from."""

    file: str
    number: int


@dataclass(frozen=True, eq=False)
class Value:
    """The result of one statement, or a parameter of a function; `name` is for readers."""

    kind: Kind
    name: str = ""


@dataclass(frozen=True)
class Immediate:
    """A number of the program itself. Zeros of either sign and NaN are constants of their own."""

    kind: Kind
    value: float | int | bool


@dataclass(frozen=True, eq=False)
class Variable:
    """A variable, which may be set again; zero or false until then. See `Function.variables`."""

    kind: Kind
    name: str = ""


@dataclass(frozen=True, eq=False)
class Storage:
    """Memory of the caller, or a part of another array; entries are numbered from 0.

    Arrays among the parameters of the entry never overlap. Those of another function may, if its
    callers pass them so.
    """

    entry: Kind
    length: int | None  # None where only the caller knows it
    writable: bool
    name: str = ""


Operand: TypeAlias = Value | Immediate


# -- operations without effect ---------------------------------------------------------------------


class Signature(NamedTuple):
    """Kinds of an operation's operands, kind of its result, and its meaning; None stands for any one kind."""

    operands: tuple[Kind | None, ...]
    result: Kind | None
    meaning: str


_FF, _II, _TT = (FLOAT, FLOAT), (INTEGER, INTEGER), (TRUTH, TRUTH)

OPERATIONS: dict[str, Signature] = {
    # numbers, rounded to nearest even
    "add": Signature(_FF, FLOAT, "a + b"),
    "subtract": Signature(_FF, FLOAT, "a - b"),
    "multiply": Signature(_FF, FLOAT, "a * b"),
    "divide": Signature(_FF, FLOAT, "a / b as IEEE 754 has it: infinite or NaN for b = 0"),
    "negate": Signature((FLOAT,), FLOAT, "-a, the sign bit alone"),
    "absolute": Signature((FLOAT,), FLOAT, "|a|, the sign bit alone"),
    "copy_sign": Signature(_FF, FLOAT, "|a| with the sign bit of b"),
    "square_root": Signature((FLOAT,), FLOAT, "square root, correctly rounded; NaN below zero"),
    "floor": Signature((FLOAT,), FLOAT, "the largest whole number not above a"),
    "ceiling": Signature((FLOAT,), FLOAT, "the smallest whole number not below a"),
    "truncate": Signature((FLOAT,), FLOAT, "a without its fraction"),
    "round_half_even": Signature((FLOAT,), FLOAT, "the nearest whole number, the even one of two"),
    "less": Signature(_FF, TRUTH, "a < b; false for NaN"),
    "less_equal": Signature(_FF, TRUTH, "a <= b; false for NaN"),
    "equal": Signature(_FF, TRUTH, "a == b; false for NaN"),
    "not_equal": Signature(_FF, TRUTH, "a != b; true for NaN"),
    # integers, modulo 2^64 with sign
    "add_integers": Signature(_II, INTEGER, "a + b"),
    "subtract_integers": Signature(_II, INTEGER, "a - b"),
    "multiply_integers": Signature(_II, INTEGER, "a * b"),
    "add_overflows": Signature(_II, TRUTH, "whether 64 bits do not hold a + b"),
    "subtract_overflows": Signature(_II, TRUTH, "whether 64 bits do not hold a - b"),
    "multiply_overflows": Signature(_II, TRUTH, "whether 64 bits do not hold a * b"),
    "floor_divide": Signature(_II, INTEGER, "a // b; any value for b = 0 and for -2^63 // -1, but no trap"),
    "modulo": Signature(_II, INTEGER, "a % b with the sign of b; any value for b = 0, but no trap"),
    "and": Signature(_II, INTEGER, "bits of both"),
    "or": Signature(_II, INTEGER, "bits of either"),
    "xor": Signature(_II, INTEGER, "bits of one"),
    "shift_left": Signature(_II, INTEGER, "a << b modulo 2^64 for 0 <= b < 64; any value for another b"),
    "shift_right": Signature(_II, INTEGER, "a >> b with sign for 0 <= b < 64; any value for another b"),
    "less_integers": Signature(_II, TRUTH, "a < b"),
    "less_equal_integers": Signature(_II, TRUTH, "a <= b"),
    "equal_integers": Signature(_II, TRUTH, "a == b"),
    "not_equal_integers": Signature(_II, TRUTH, "a != b"),
    # truth values
    "both": Signature(_TT, TRUTH, "a and b, both known"),
    "either": Signature(_TT, TRUTH, "a or b, both known"),
    "differ": Signature(_TT, TRUTH, "a != b"),
    "not": Signature((TRUTH,), TRUTH, "not a"),
    "likely": Signature((TRUTH,), TRUTH, "a, which is true as a rule: what is chosen by it need not wait for it"),
    # of any kind
    "select": Signature((TRUTH, None, None), None, "b if a else c, both known"),
    # from kind to kind
    "float_of_integer": Signature((INTEGER,), FLOAT, "the nearest number, the even one of two"),
    "integer_of_float": Signature((FLOAT,), INTEGER, "a without its fraction; any value beyond 64 bits and for NaN"),
    "integer_of_truth": Signature((TRUTH,), INTEGER, "1 or 0"),
    "float_of_truth": Signature((TRUTH,), FLOAT, "1.0 or 0.0"),
    "bits_of_float": Signature((FLOAT,), INTEGER, "the 64 bits of a number as an integer"),
    "float_of_bits": Signature((INTEGER,), FLOAT, "the number of 64 bits"),
}


# -- statements ------------------------------------------------------------------------------------


class Compute(NamedTuple):
    """`result` = `operation` of the operands."""

    result: Value
    operation: str  # of OPERATIONS
    operands: tuple[Operand, ...]
    line: Line | None = None


class Get(NamedTuple):
    """`result` = current value of a variable."""

    result: Value
    variable: Variable
    line: Line | None = None


class Set(NamedTuple):
    """Set a variable to a value."""

    variable: Variable
    value: Operand
    line: Line | None = None


class Load(NamedTuple):
    """`result` = an entry of an array; the index is within it."""

    result: Value
    array: Storage
    at: Operand
    line: Line | None = None


class Store(NamedTuple):
    """Set an entry of an array to a value."""

    array: Storage
    at: Operand
    value: Operand
    line: Line | None = None


class View(NamedTuple):
    """`part` stands for `part.length` entries of `whole` from an index on."""

    part: Storage
    whole: Storage
    first: Operand
    line: Line | None = None


class Call(NamedTuple):
    """`results` = results of a function for these arguments, in the order of its parameters."""

    results: tuple[Value, ...]
    function: "Function | External"
    arguments: tuple[Operand | Storage, ...]
    line: Line | None = None


class If(NamedTuple):
    """Execute one region or the other, by a condition."""

    condition: Operand
    then: "Region"
    otherwise: "Region"
    line: Line | None = None


class For(NamedTuple):
    """The body for `counter` = first, first + step, ... as long as it is below last; the three are read once before."""

    counter: Value
    first: Operand
    last: Operand
    step: int  # not 0; with a negative one as long as the counter is above last
    body: "Region"
    line: Line | None = None


class While(NamedTuple):
    """Execute the test and, while its condition holds, the body and the test again. The body may read the test.

    The test leaves neither the loop around it nor the function.
    """

    test: "Region"
    condition: Operand
    body: "Region"
    line: Line | None = None


class Break(NamedTuple):
    """Leave the innermost loop."""

    line: Line | None = None


class Continue(NamedTuple):
    """Continue with the next turn of the innermost loop."""

    line: Line | None = None


class Return(NamedTuple):
    """Return from the function with these results."""

    values: tuple[Operand, ...] = ()
    line: Line | None = None


Statement: TypeAlias = Compute | Get | Set | Load | Store | View | Call | If | For | While | Break | Continue | Return
Region: TypeAlias = list[Statement]


# -- functions and programs ------------------------------------------------------------------------


@dataclass(eq=False)
class Function:
    """A function; a body that ends without `Return` returns nothing, with empty `results`."""

    name: str  # unique in its program, letters, digits and underscores
    parameters: tuple[Value | Storage, ...]
    results: tuple[Kind, ...]
    body: Region = field(default_factory=list)
    variables: list[Variable] = field(default_factory=list)
    origin: str = ""  # Python function that it comes from, for readers
    inline: bool = False  # whether targets inline it
    apart: bool = False  # whether targets never inline it: part of a function too long


@dataclass(frozen=True)
class External:
    """A function of another library, called by the conventions of C: `sin` of libm, or a compiled model of hardware."""

    symbol: str
    parameters: tuple[Kind, ...]
    result: Kind | None
    address: int | None = field(default=None, compare=False, repr=False)  # None where the linker knows the symbol
    pure: bool = True  # the result follows from the arguments alone, without side effects


@dataclass
class Program:
    """Functions by name, those that are called before those that call them; the last is called from outside."""

    functions: dict[str, Function]

    @property
    def entry(self) -> Function:
        """The function that is called from outside."""
        return list(self.functions.values())[-1]
