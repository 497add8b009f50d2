"""Each operation of the form in LLVM's language: one instruction, or a small function that is always inlined."""

import struct
from typing import NamedTuple

from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, For, Immediate, Kind, Operand

TYPES = {FLOAT: "double", INTEGER: "i64", TRUTH: "i1"}
ZEROS = {FLOAT: "0.0", INTEGER: "0", TRUTH: "false"}
_FLOAT_BINARY = {"add": "fadd", "subtract": "fsub", "multiply": "fmul", "divide": "fdiv"}
_FLOAT_COMPARED = {"less": "olt", "less_equal": "ole", "equal": "oeq", "not_equal": "une"}
_INTEGER_BINARY = {
    "add_integers": "add", "subtract_integers": "sub", "multiply_integers": "mul", "and": "and", "or": "or",
    "xor": "xor",
}  # fmt: skip
_INTEGER_COMPARED = {
    "less_integers": "slt", "less_equal_integers": "sle", "equal_integers": "eq", "not_equal_integers": "ne",
}  # fmt: skip
_TRUTH_BINARY = {"both": "and", "either": "or", "differ": "xor"}
_INTRINSIC = {
    "absolute": "fabs", "square_root": "sqrt", "floor": "floor", "ceiling": "ceil", "truncate": "trunc",
    "round_half_even": "roundeven",
}  # fmt: skip


class Template(NamedTuple):
    """Text of an operation, with places for result and operands, and what stands beside it."""

    text: str
    needs: tuple[str, ...] = ()  # declarations and definitions


def templates(lanes: int = 0) -> dict[str, Template]:
    """Every operation on scalars, or on vectors of so many lanes."""
    f, i, t = (_type(kind, lanes) for kind in (FLOAT, INTEGER, TRUTH))
    suffix = f"v{lanes}" if lanes else ""
    templates_by_name = {name: Template(f"%s = {op} {f} %s, %s") for name, op in _FLOAT_BINARY.items()}
    templates_by_name |= {name: Template(f"%s = {op} {i} %s, %s") for name, op in _INTEGER_BINARY.items()}
    templates_by_name |= {name: Template(f"%s = {op} {t} %s, %s") for name, op in _TRUTH_BINARY.items()}
    templates_by_name |= {name: Template(f"%s = fcmp {how} {f} %s, %s") for name, how in _FLOAT_COMPARED.items()}
    templates_by_name |= {name: Template(f"%s = icmp {how} {i} %s, %s") for name, how in _INTEGER_COMPARED.items()}
    for name, intrinsic in _INTRINSIC.items():
        symbol = f"@llvm.{intrinsic}.{suffix}f64"
        templates_by_name[name] = Template(f"%s = call {f} {symbol}({f} %s)", (f"declare {f} {symbol}({f})",))
    symbol = f"@llvm.copysign.{suffix}f64"
    templates_by_name["copy_sign"] = Template(
        f"%s = call {f} {symbol}({f} %s, {f} %s)", (f"declare {f} {symbol}({f}, {f})",)
    )
    templates_by_name["negate"] = Template(f"%s = fneg {f} %s")
    templates_by_name["not"] = Template(f"%s = xor {t} %s, {splat(TRUTH, 'true', lanes)}")
    templates_by_name["float_of_integer"] = Template(f"%s = sitofp {i} %s to {f}")
    templates_by_name["integer_of_truth"] = Template(f"%s = zext {t} %s to {i}")
    templates_by_name["float_of_truth"] = Template(f"%s = uitofp {t} %s to {f}")
    templates_by_name["bits_of_float"] = Template(f"%s = bitcast {f} %s to {i}")
    templates_by_name["float_of_bits"] = Template(f"%s = bitcast {i} %s to {f}")
    return templates_by_name | _helped(f, i, t, suffix, lanes)


def _helped(f: str, i: str, t: str, suffix: str, lanes: int) -> dict[str, Template]:
    """Operations of several instructions; none is undefined for any operands."""
    templates_by_name = {}
    for name, intrinsic in {"add": "sadd", "subtract": "ssub", "multiply": "smul"}.items():
        symbol, pair = f"@llvm.{intrinsic}.with.overflow.{suffix}i64", f"{{ {i}, {t} }}"
        lines = (f"%both = call {pair} {symbol}({i} %a, {i} %b)", f"%out = extractvalue {pair} %both, 1")
        own = _function(f"{name}_overflows", t, (i, i), lines, lanes)
        templates_by_name[f"{name}_overflows"] = own._replace(needs=(f"declare {pair} {symbol}({i}, {i})", *own.needs))
    for name, instruction in {"shift_left": "shl", "shift_right": "ashr"}.items():
        lines = (f"%count = and {i} %b, {splat(INTEGER, '63', lanes)}", f"%out = {instruction} {i} %a, %count")
        templates_by_name[name] = _function(name, i, (i, i), lines, lanes)
    templates_by_name["integer_of_float"] = _function(
        "integer_of_float", i, (f,), (f"%cut = fptosi {f} %a to {i}", f"%out = freeze {i} %cut"), lanes
    )
    one, zero, minus = (splat(INTEGER, number, lanes) for number in ("1", "0", "-1"))
    guarded = (
        f"%next = add {i} %b, {one}",
        f"%special = icmp ult {i} %next, {splat(INTEGER, '2', lanes)}",  # 0 or -1
        f"%by = select {t} %special, {i} {one}, {i} %b",
        f"%left = srem {i} %a, %by",
        f"%signs = xor {i} %left, %by",
        f"%apart = icmp slt {i} %signs, {zero}",
        f"%some = icmp ne {i} %left, {zero}",
        f"%low = and {t} %apart, %some",
    )
    templates_by_name["modulo"] = _function(
        "modulo",
        i,
        (i, i),
        (*guarded, f"%more = select {t} %low, {i} %by, {i} {zero}", f"%out = add {i} %left, %more"),
        lanes,
    )
    quotient = (
        f"%towards = sdiv {i} %a, %by",
        f"%less = sext {t} %low to {i}",
        f"%down = add {i} %towards, %less",
        f"%other = sub {i} {zero}, %a",
        f"%opposite = icmp eq {i} %b, {minus}",
        f"%out = select {t} %opposite, {i} %other, {i} %down",
    )
    templates_by_name["floor_divide"] = _function("floor_divide", i, (i, i), (*guarded, *quotient), lanes)
    return templates_by_name


def _function(name: str, result: str, kinds: tuple[str, ...], lines: tuple[str, ...], lanes: int) -> Template:
    symbol = f"@op.{name}.{lanes}" if lanes else f"@op.{name}"
    parameters = ", ".join(f"{kind} %{letter}" for kind, letter in zip(kinds, "ab", strict=False))
    body = "\n  ".join(lines)
    text = f"define internal {result} {symbol}({parameters}) #1 {{\n  {body}\n  ret {result} %out\n}}"
    return Template(f"%s = call {result} {symbol}({', '.join(f'{kind} %s' for kind in kinds)})", (text,))


def _portable() -> dict[str, Template]:
    """Operations on scalars for WebAssembly.

    It does not say whether a product fits. Its conversion of integers is written out, to the same
    bits: Chromium 150's waits for a register that it does not need, which doubles the time of a
    closed loop.
    """
    lines = (
        "%product = mul i64 %a, %b",
        "%next = add i64 %b, 1",
        "%special = icmp ult i64 %next, 2",  # 0 or -1
        "%by = select i1 %special, i64 1, i64 %b",
        "%back = sdiv i64 %product, %by",
        "%other = icmp ne i64 %back, %a",
        "%opposite = icmp eq i64 %b, -1",
        f"%lowest = icmp eq i64 %a, {-(2**63)}",
        "%too_low = and i1 %opposite, %lowest",
        "%out = select i1 %special, i1 %too_low, i1 %other",
    )
    # 2^52 with the low half as its last bits, and 2^84 + 2^63 with the high half; their sum less these is rounded once
    parts = (
        "%low_bits = and i64 %a, 4294967295",
        "%low_word = or i64 %low_bits, 4841369599423283200",
        "%high_bits = lshr i64 %a, 32",
        "%high_word = xor i64 %high_bits, 4985484789646622720",
        "%low = bitcast i64 %low_word to double",
        "%high = bitcast i64 %high_word to double",
        "%exact = fsub double %high, 0x4530000080100000",  # 2^84 + 2^63 + 2^52
        "%out = fadd double %exact, %low",
    )
    return {
        "multiply_overflows": _function("multiply_overflows", "i1", ("i64", "i64"), lines, 0),
        "float_of_integer": _function("float_of_integer", "double", ("i64",), parts, 0),
    }


def select(kind: Kind, lanes: int = 0, condition_lanes: int = 0) -> str:
    """Text of a selection among two of a kind; the condition may be of one for all lanes."""
    of = _type(kind, lanes)
    return f"%s = select {_type(TRUTH, condition_lanes)} %s, {of} %s, {of} %s"


def _type(kind: Kind, lanes: int) -> str:
    return f"<{lanes} x {TYPES[kind]}>" if lanes else TYPES[kind]


def splat(kind: Kind, number: str, lanes: int) -> str:
    """A constant for every lane."""
    return f"splat ({TYPES[kind]} {number})" if lanes else number


def constant(operand: Immediate) -> str:
    """A number as LLVM writes it, to the bit."""
    if operand.kind is FLOAT:
        return f"0x{struct.unpack('<Q', struct.pack('<d', operand.value))[0]:016X}"
    if operand.kind is TRUTH:
        return "true" if operand.value else "false"
    return str(operand.value)


def power_of_two(operand: Operand) -> int | None:
    """The exponent of a constant that is a power of two."""
    value = operand.value if isinstance(operand, Immediate) else 0
    return int(value).bit_length() - 1 if value > 0 and not int(value) & (int(value) - 1) else None


def cannot_overflow(loop: For) -> bool:
    """Return whether 64 bits surely hold the first counter that is not below the last."""
    if loop.step in (1, -1):
        return True
    return isinstance(loop.last, Immediate) and abs(loop.last.value + loop.step) < 2**63


NATIVE = templates()
PORTABLE = NATIVE | _portable()
