"""Each operation of the form in C99: an operator, a function of libm, or one written out."""

from proofmass.runner.program.form import FLOAT, INTEGER, OPERATIONS, TRUTH

TYPES = {FLOAT: "double", INTEGER: "int64_t", TRUTH: "bool"}
INFIX = {
    "add": "+", "subtract": "-", "multiply": "*", "divide": "/", "less": "<", "less_equal": "<=", "equal": "==",
    "not_equal": "!=", "and": "&", "or": "|", "xor": "^", "less_integers": "<", "less_equal_integers": "<=",
    "equal_integers": "==", "not_equal_integers": "!=", "both": "&", "either": "|", "differ": "!=",
}  # fmt: skip
CALLED = {
    "absolute": "fabs", "copy_sign": "copysign", "square_root": "sqrt", "floor": "floor", "ceiling": "ceil",
    "truncate": "trunc", "round_half_even": "rint", "not": "!", "float_of_integer": "(double)",
    "integer_of_truth": "(int64_t)", "float_of_truth": "(double)",
}  # fmt: skip

_BODIES = {  # in an order in which each knows those that it calls
    "add_integers": "return (int64_t)((uint64_t)a + (uint64_t)b);",
    "subtract_integers": "return (int64_t)((uint64_t)a - (uint64_t)b);",
    "multiply_integers": "return (int64_t)((uint64_t)a * (uint64_t)b);",
    "add_overflows": "return b > 0 ? a > INT64_MAX - b : a < INT64_MIN - b;",
    "subtract_overflows": "return b > 0 ? a < INT64_MIN + b : a > INT64_MAX + b;",
    "multiply_overflows": """\
if (b == 0) return false;
    if (b == -1) return a == INT64_MIN;
    return (int64_t)((uint64_t)a * (uint64_t)b) / b != a;""",
    "floor_divide": """\
if (b == 0) return a;
    if (b == -1) return (int64_t)(0 - (uint64_t)a);
    return a / b - (a % b != 0 && (a % b < 0) != (b < 0)); /* rounded down */""",
    "modulo": """\
if (b == 0 || b == -1) return 0;
    return a % b + (a % b != 0 && (a % b < 0) != (b < 0) ? b : 0); /* left of a / b rounded down */""",
    "shift_left": "return (int64_t)((uint64_t)a << (b & 63));",
    "shift_right": "return a < 0 ? (int64_t)~(~(uint64_t)a >> (b & 63)) : (int64_t)((uint64_t)a >> (b & 63));",
    "integer_of_float": "return a >= -9223372036854775808.0 && a < 9223372036854775808.0 ? (int64_t)a : 0;",
    "bits_of_float": "int64_t bits;\n    memcpy(&bits, &a, sizeof bits);\n    return bits;",
    "float_of_bits": "double number;\n    memcpy(&number, &a, sizeof number);\n    return number;",
}


def _helper(name: str) -> str:
    """Return the definition of a small function, whose types are those of the operation."""
    kinds, result, _ = OPERATIONS[name]
    parameters = ", ".join(f"{TYPES[kind or FLOAT]} {letter}" for kind, letter in zip(kinds, "ab", strict=False))
    return f"static inline {TYPES[result or FLOAT]} {name}({parameters})\n{{\n    {_BODIES[name]}\n}}\n"


HELPERS = {name: _helper(name) for name in _BODIES}

_KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long register "
    "restrict return short signed sizeof static struct switch typedef union unsigned void volatile while bool true "
    "false main"
)
_MATH = (
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh div erf erfc exp exp2 expm1 fabs fdim floor "
    "fma fmax fmin fmod frexp gamma hypot ilogb isfinite isinf isnan isnormal signbit j0 j1 jn ldexp lgamma llrint "
    "llround log log10 log1p log2 logb lrint lround memcpy memset modf nan nearbyint nextafter nexttoward pow "
    "remainder remquo rint round scalbln scalbn sin sinh sqrt tan tanh tgamma trunc y0 y1 yn NAN INFINITY HUGE_VAL "
    "INT64_MIN INT64_MAX"
)
RESERVED = (*_KEYWORDS.split(), *_MATH.split(), *HELPERS)
