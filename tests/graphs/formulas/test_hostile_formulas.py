"""Two hundred hostile texts in place of a formula: each is refused at its line, in words; none is evaluated."""

import time

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import quoted

CODE = """
__import__('os').system('true')
__import__("os")
open('/etc/passwd')
open("x", "w")
eval('1')
exec('1')
compile('1', '', 'eval')
globals()
locals()
vars()
dir()
input()
print(1)
exit()
quit()
lambda: 1
lambda x: x
(lambda: 1)()
[x for x in (1, 2)]
{x for x in (1, 2)}
{1: 2}
{1, 2}
[1, 2]
(1, 2)
()
mass.__class__
mass.real
().__class__
1 .__class__
1.0.__class__
mass.__class__.__bases__
mass if 1 else 2
mass or 1
mass and 1
not mass
mass is 1
mass in mass
mass := 1
(mass := 1)
mass == 1
mass != 1
mass < 1
mass > 1
mass <= 1
mass >= 1
mass = 1
mass += 1
mass; mass
mass, mass
mass @ mass
mass // 2
mass % 2
mass | 1
mass & 1
~mass
mass << 1
mass >> 1
mass[0]
mass[:]
mass()
mass(1)
*mass
**mass
await mass
yield mass
async mass
import os
from os import path
assert mass
del mass
raise mass
return mass
pass
None
True
False
...
f"{mass}"
'mass'
"mass"
'''mass'''
b"mass"
r"mass"
`mass`
$mass
$(mass)
${mass}
#{mass}
{{ mass }}
{% mass %}
<mass>
&mass;
mass\\n
mass\\
// mass
/* mass */
-- mass --
mass -- comment
mass # comment
math.pi
os.system
numpy.pi
np.sqrt(2)
cos.real
self.mass
sensor.mass
blocks.sensor.mass
values.mass
..mass
mass..
.mass
mass.
a.b.c.d
"""

MALFORMED = """
+
-
*
/
^
**
(
)
((
))
)(
,
2 +
2 *
2 /
2 ^
* 2
/ 2
^ 2
2 3
2 mass
mass 2
mass mass
2 ** ** 2
2 * / 2
2 + * 2
(2
2)
((2)
(2))
sin
sin 2
sin(
sin()
sin(1, 2)
sin(,)
hypot(1)
hypot(1,)
hypot(,1)
hypot(1, 2, 3)
foo(1)
1,5
1.2.3
1..2
1e
1e+
1 e5 e5
1e5e5
0x10
0b1
0o7
1j
1_
_1
1e500
1e99999
1e-500
1e+401
9e999999999999
2 m^x
2 m^
2 m^(1/2)
2 m^^2
2 Vx
2 kkg
2 mkg
infinity
inf
nan
-inf
e
tau
π
×
÷
−1
2·3
２
²
mass²
m²
½
∞
√2
٢
𝟐
maꜱs
mаss
mass\u200b
\u202emass
é
名
🚀
\u0000
\u001b[31m
"""

UNITS = """
1 V
2
pi
mass * mass
mass / mass
mass + 1
mass - 1 V
1 kg + 1 m
sqrt(mass)
mass^2
mass^0
mass^0.5
sin(mass)
exp(mass)
log(mass)
mass^mass
2^mass
mass^pi
mass^f0
max(mass, 1)
min(mass, f0)
hypot(mass, 1 m)
atan2(mass, 1 m)
abs(f0)
f0 / f0
0
-0
mass * 1 V
mass / 1 s
1 / mass
"""

VALUES = """
-mass
0 kg
mass * 0
mass - mass
mass / 0
mass / (1 - 1)
mass * sqrt(-1)
mass * log(0)
mass * log(-1)
mass * acos(2)
mass * 0^-1
mass * exp(1000)
mass * 10^400
mass * 1e300 * 1e300
mass * (-2)^0.5
1e308 kg * 10
unknown
mas
Mass
MASS
circle
other
"""

LONG = [
    "(" * 200 + "mass" + ")" * 190,
    "-" * 399,
    "2^" * 190 + "2",
    "mass+" * 79 + "mass * mass",
    "mass" * 99,
    "9" * 399,
    "m" * 399,
    "1 " * 199,
    "sin(" * 99,
    "mass + " * 1000 + "mass",
    "(" * 100_000,
    "1" * 100_000,
    " " * 100_000,
    "((((((((((((((((((((((((mass))))))))))))))))))))))))",
    "1 kg^99999",
    "1 kg^999999999999",
    "(1 kg^12)^64",
    "((1 kg)^64)^64",
    "1 kg^12 kg^12 kg^12 kg^12 kg^12 kg^12 kg^12 kg^12 kg^12 kg^12",
]
TEXTS = [*(line for part in (CODE, MALFORMED, UNITS, VALUES) for line in part.strip().splitlines()), *LONG]

GRAPH = """\
name = "hostile"
rate = "1 kHz"

[values]
mass = "50 ug"
f0 = "8 kHz"
circle = "= other"
other = "= circle"

[blocks.sensor]
kind = "MassSpringDamper"
mass = FORMULA
"""


def refusal(text: str) -> ModelError:
    with pytest.raises(ModelError) as refused:
        read_graph_text(GRAPH.replace("FORMULA", quoted(f"= {text}")), "hostile.toml")
    return refused.value


def test_there_are_two_hundred() -> None:
    assert len(set(TEXTS)) >= 200


@pytest.mark.parametrize("text", TEXTS, ids=lambda text: ascii(text[:24]))
def test_it_is_refused_at_its_line(text: str) -> None:
    began = time.process_time()
    problems = refusal(text).problems
    assert time.process_time() - began < 5.0  # it does not hang; the garbage collector may pause
    own = [problem for problem in problems if problem.key.startswith("blocks.sensor.mass")]
    circle = [problem for problem in problems if problem.key.startswith("values.circle")]
    assert len(circle) == 1
    assert len(own) + len(circle) == len(problems) <= 2
    for problem in own:
        assert (problem.file, problem.line) == ("hostile.toml", 12)
        assert 8 < len(problem.message) < 160
        assert problem.message.isprintable()
        assert problem.got
    if text not in ("circle", "other"):
        assert own


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("__import__('os').system('true')", "a formula has no texts in it"),
        ("mass.__class__", "a formula knows values, not parameters"),
        ("lambda: 1", "a formula has no :"),
        ("eval(1)", "there is no function eval"),
        ("mass == 1", "a formula has no ="),
        ("(" * 100, "nested deeper than 24 levels"),
        ("mass + " * 1000 + "mass", "over 400 characters"),
        ("1e500", "an exponent of ten beyond 400"),
        ("mаss", "cannot be read at"),
    ],
)
def test_what_is_said(text: str, message: str) -> None:
    assert any(message in problem.message for problem in refusal(text).problems)
