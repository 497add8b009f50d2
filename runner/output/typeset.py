"""Equations of docstrings as HTML: Greek letters, powers, indices, roots and dots in print, prose as prose.

x_i' = w^2 sqrt(m / k)    becomes    x with the index i, w with the exponent 2, and a root
"""

import re
from html import escape

_GREEK = {"alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "eta": "η", "theta": "θ"}
_GREEK |= {"kappa": "κ", "lambda": "λ", "mu": "μ", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "psi": "ψ"}
_GREEK |= {"omega": "ω", "Omega": "Ω", "pi": "π", "zeta": "ζ", "eps0": "ε<sub>0</sub>", "mu0": "μ<sub>0</sub>"}
_FULL = 85  # letters of a line of a docstring that was broken for want of room
_WORD = re.compile(rf"\b({'|'.join(sorted(_GREEK, key=len, reverse=True))})\b")
_POWER = re.compile(r"\^(-?\w+|\([^()]*\))")
_INDEX = re.compile(r"(?<=[A-Za-z\]])_(\d+|[a-z]|\([^()]*\))(?![\w])")
_ROOT = re.compile(r"\bsqrt\(")
_SIGNS = ((" -+ ", " ∓ "), (" +- ", " ± "), ("+-", "±"), (" >= ", " ≥ "), (" <= ", " ≤ "), ("->", "→"), (" != ", " ≠ "))


def typeset(text: str) -> str:
    """Return the equation of a block, prose and formulas, as HTML: paragraphs, and indented lines set apart.

    Names in backquotes are code. All else is escaped: the HTML has nothing but paragraphs, breaks,
    code and indices.
    """
    blocks = re.split(r"\n\s*\n", unwrapped(text).strip("\n"))
    return "\n".join(_set(block) for block in blocks if block.strip())


def _set(block: str) -> str:
    apart = all(line.startswith("    ") for line in block.splitlines())
    lines = "<br>".join(_with_code(line.strip()) for line in block.splitlines())
    return f'<p class="{"display" if apart else "prose"}">{lines}</p>'


def _with_code(line: str) -> str:
    words = line.split("`")
    if len(words) % 2 == 0:  # a backquote of its own
        return _formulas(line)
    return "".join(f"<code>{escape(word)}</code>" if i % 2 else _formulas(word) for i, word in enumerate(words))


def unwrapped(text: str) -> str:
    """Return text whose full lines run on into the next one, so that a page breaks them where it has room.

    >>> unwrapped("x = 1\\ny = 2")
    'x = 1\\ny = 2'
    """
    lines = text.splitlines()
    runs_on = [
        len(line) > _FULL and bool(after.strip()) and not after.startswith(" ")
        for line, after in zip(lines, [*lines[1:], ""], strict=True)
    ]
    return "".join(line + (" " if joined else "\n") for line, joined in zip(lines, runs_on, strict=True)).rstrip("\n")


def _formulas(line: str) -> str:
    """Return a line with its signs in print.

    >>> _formulas("w^2 = 4 pi^2 x_1 / sqrt(m k)")
    'w<sup>2</sup> = 4 π<sup>2</sup> x<sub>1</sub> / √(m k)'
    """
    for plain, printed in _SIGNS:
        line = line.replace(plain, printed)
    line = _ROOT.sub("√(", escape(line, quote=False))
    line = _POWER.sub(lambda power: f"<sup>{power[1].strip('()').replace('-', '−')}</sup>", line)
    line = _INDEX.sub(lambda index: f"<sub>{index[1].strip('()')}</sub>", line)
    return _WORD.sub(lambda word: _GREEK[word[1]], line)
