r"""Equations of terms, a small part of LaTeX, as MathML: every current browser sets it without a script.

What is not in that part (\frac, \sqrt, ^, _, Greek, the usual functions and signs) is shown as it was written.
"""

from __future__ import annotations

import re

from markupsafe import Markup, escape

_TOKEN = re.compile(r"\\([A-Za-z]+|.)|(\d+(?:\.\d+)?)|([{}^_&])|(\s+)|(.)", re.DOTALL)


def _pairs(text: str) -> dict[str, str]:
    """Dictionary of alternating names and signs."""
    parts = text.split()
    return dict(zip(parts[::2], parts[1::2], strict=True))


_LETTERS = _pairs(
    """alpha α beta β gamma γ delta δ epsilon ε zeta ζ eta η theta θ kappa κ lambda λ mu μ nu ν xi ξ pi π rho ρ
    sigma σ tau τ phi φ chi χ psi ψ omega ω Gamma Γ Delta Δ Theta Θ Lambda Λ Xi Ξ Pi Π Sigma Σ Phi Φ Psi Ψ Omega Ω
    varphi ϕ vartheta ϑ varepsilon ϵ ell ℓ infty ∞"""
)
_SIGNS = _pairs(
    """cdot ⋅ times × le ≤ leq ≤ ge ≥ geq ≥ ne ≠ neq ≠ approx ≈ pm ± mp ∓ to → rightarrow → uparrow ↑ downarrow ↓
    sum ∑ int ∫ prod ∏ in ∈ mid | ldots … dots … cdots ⋯ partial ∂ lceil ⌈ rceil ⌉ lfloor ⌊ rfloor ⌋
    lvert | rvert | lVert ‖ rVert ‖ langle ⟨ rangle ⟩ ll ≪ gg ≫ propto ∝ sim ∼ circ ∘"""
)
_WORD = re.compile(r"\{([A-Za-z]{2,})\}")
_SPACES = {",": "0.17em", ";": "0.28em", ":": "0.22em", " ": "0.28em", "!": "0em"}
_QUADS = {"quad": "1em", "qquad": "2em"}
_ACCENTS = {"dot": "˙", "ddot": "¨", "hat": "^", "bar": "¯", "overline": "¯", "vec": "→", "tilde": "~"}
_FUNCTIONS = frozenset(
    (
        "sin",
        "cos",
        "tan",
        "exp",
        "log",
        "ln",
        "max",
        "min",
        "sgn",
        "sign",
        "arctan",
        "arccos",
        "arcsin",
        "lim",
    )
)
_UPRIGHT = frozenset(("text", "mathrm", "operatorname", "mathit", "textrm", "mathbf", "boldsymbol"))


class _UnknownError(Exception):
    """The equation uses LaTeX that is not supported here."""


def mathml(latex: str) -> Markup:
    """The equation as <math>, or as <code> if it contains unsupported LaTeX."""
    source = latex.strip().strip("$").strip()
    if not source:
        return Markup("")
    try:
        body = _Setter(source).all()
    except (_UnknownError, RecursionError):
        return Markup(f"<code>{escape(source)}</code>")
    return Markup(f'<math display="block" alttext="{escape(source)}"><mrow>{body}</mrow></math>')


class _Setter:
    """Reads tokens and writes MathML."""

    def __init__(self, source: str) -> None:
        self._tokens = [m for m in _TOKEN.finditer(source) if m[4] is None]
        self._source = source
        self._at = 0

    def all(self) -> str:
        body = self._row()
        if self._at < len(self._tokens):
            raise _UnknownError
        return body

    def _row(self) -> str:
        """MathML up to the closing brace or the end."""
        out = []
        while self._at < len(self._tokens) and self._tokens[self._at][0] != "}":
            out.append(self._scripted())
        return "".join(out)

    def _scripted(self) -> str:
        base = self._one()
        below = above = ""
        while self._at < len(self._tokens) and self._tokens[self._at][0] in "^_'":
            mark = self._next()[0]
            script = "<mo>′</mo>" if mark == "'" else self._word() or self._one()
            if (below if mark == "_" else above) != "":
                raise _UnknownError
            above, below = (above, script) if mark == "_" else (script, below)
        if above and below:
            return f"<msubsup>{base}{below}{above}</msubsup>"
        return f"<msup>{base}{above}</msup>" if above else f"<msub>{base}{below}</msub>" if below else base

    def _word(self) -> str:
        """A script of several letters in braces as an upright word; "" if none begins at this token."""
        found = (
            _WORD.match(self._source, self._tokens[self._at].start())
            if self._at < len(self._tokens)
            else None
        )
        if found is None:
            return ""
        while self._tokens[self._at].end() < found.end():
            self._at += 1
        self._at += 1
        return f"<mtext>{found[1]}</mtext>"

    def _next(self) -> re.Match[str]:
        if self._at >= len(self._tokens):
            raise _UnknownError
        self._at += 1
        return self._tokens[self._at - 1]

    def _one(self) -> str:
        token = self._next()
        if token[1]:
            return self._command(token[1])
        if token[2]:
            return f"<mn>{token[2]}</mn>"
        if token[0] == "{":
            body = self._row()
            if self._next()[0] != "}":
                raise _UnknownError
            return f"<mrow>{body}</mrow>"
        if token[3]:
            raise _UnknownError
        sign = token[0].replace("-", "−")
        return f"<mi>{escape(sign)}</mi>" if sign.isalpha() else f"<mo>{escape(sign)}</mo>"

    def _command(self, name: str) -> str:
        if name in _LETTERS:
            return f"<mi>{_LETTERS[name]}</mi>"
        if name in _SIGNS:
            return f"<mo>{_SIGNS[name]}</mo>"
        if name in _FUNCTIONS:
            return f"<mi>{name}</mi>"
        if name in _SPACES or name in _QUADS:
            return f'<mspace width="{_SPACES.get(name) or _QUADS[name]}"/>'
        if name in _UPRIGHT:
            return f"<mtext>{escape(self._braced())}</mtext>"
        if name in _ACCENTS:
            return f'<mover accent="true">{self._one()}<mo>{_ACCENTS[name]}</mo></mover>'
        if name in ("frac", "tfrac", "dfrac"):
            return f"<mfrac>{self._one()}{self._one()}</mfrac>"
        if name == "sqrt":
            return f"<msqrt>{self._one()}</msqrt>"
        if name in ("left", "right", "big", "Big", "bigl", "bigr"):
            token = self._next()
            return "" if token[0] == "." else f"<mo>{escape(self._fence(token))}</mo>"
        if name in "{}%_&|#":
            return f"<mo>{escape('‖' if name == '|' else name)}</mo>"
        raise _UnknownError

    @staticmethod
    def _fence(token: re.Match[str]) -> str:
        if token[1]:
            found = _SIGNS.get(token[1], token[1] if token[1] in "{}|" else "")
            if not found:
                raise _UnknownError
            return found
        return token[0]

    def _braced(self) -> str:
        """The text in braces, including blanks."""
        if self._next()[0] != "{":
            raise _UnknownError
        begin = self._tokens[self._at - 1].end()
        while (token := self._next())[0] != "}":
            if token[0] == "{":
                raise _UnknownError
        return self._source[begin : token.start()].replace("\\", "")
