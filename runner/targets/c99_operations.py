"""Each operation of the form in C99: an operator, a function of libm, or a small function written out."""

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

HELPERS = {  # in an order in which each knows those that it calls
    "add_integers": """\
static inline int64_t add_integers(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}
""",
    "subtract_integers": """\
static inline int64_t subtract_integers(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a - (uint64_t)b);
}
""",
    "multiply_integers": """\
static inline int64_t multiply_integers(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a * (uint64_t)b);
}
""",
    "add_overflows": """\
static inline bool add_overflows(int64_t a, int64_t b)
{
    return b > 0 ? a > INT64_MAX - b : a < INT64_MIN - b;
}
""",
    "subtract_overflows": """\
static inline bool subtract_overflows(int64_t a, int64_t b)
{
    return b > 0 ? a < INT64_MIN + b : a > INT64_MAX + b;
}
""",
    "multiply_overflows": """\
static inline bool multiply_overflows(int64_t a, int64_t b)
{
    if (b == 0) return false;
    if (b == -1) return a == INT64_MIN;
    return (int64_t)((uint64_t)a * (uint64_t)b) / b != a;
}
""",
    "floor_divide": """\
/* a / b rounded down */
static inline int64_t floor_divide(int64_t a, int64_t b)
{
    if (b == 0) return a;
    if (b == -1) return (int64_t)(0 - (uint64_t)a);
    return a / b - (a % b != 0 && (a % b < 0) != (b < 0));
}
""",
    "modulo": """\
/* what is left of a / b rounded down */
static inline int64_t modulo(int64_t a, int64_t b)
{
    if (b == 0 || b == -1) return 0;
    return a % b + (a % b != 0 && (a % b < 0) != (b < 0) ? b : 0);
}
""",
    "shift_left": """\
static inline int64_t shift_left(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a << (b & 63));
}
""",
    "shift_right": """\
static inline int64_t shift_right(int64_t a, int64_t b)
{
    return a < 0 ? (int64_t)~(~(uint64_t)a >> (b & 63)) : (int64_t)((uint64_t)a >> (b & 63));
}
""",
    "integer_of_float": """\
static inline int64_t integer_of_float(double a)
{
    return a >= -9223372036854775808.0 && a < 9223372036854775808.0 ? (int64_t)a : 0;
}
""",
    "bits_of_float": """\
static inline int64_t bits_of_float(double a)
{
    int64_t bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}
""",
    "float_of_bits": """\
static inline double float_of_bits(int64_t bits)
{
    double a;
    memcpy(&a, &bits, sizeof a);
    return a;
}
""",
}

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
