"""KRL: names that are declared, in the program or in its .dat.

Layout: blocks indented, the body of a routine not, as the controller's editor does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.languages.tokens import BlockLayout, Pattern, TokenKind, Words, listed

_KINDS = {
    **dict.fromkeys(("POS", "E6POS", "AXIS", "E6AXIS"), TokenKind.POINT),
    "FRAME": TokenKind.FRAME,
    "SIGNAL": TokenKind.SIGNAL,
}
_LINE = re.compile(
    r"\s*(?:(?:DECL|GLOBAL|CONST|SIGNAL(?=\s+\w+\s+\$))\s+)*([A-Z_]\w*)\s+([A-Z_]\w*)\s*(?:[=,\[]|$|;)",
    re.IGNORECASE,
)
_SIGNAL = re.compile(r"\s*(?:(?:DECL|GLOBAL)\s+)*SIGNAL\s+([A-Z_]\w*)", re.IGNORECASE)
_NEXT = re.compile(r"\s*,\s*([A-Z_]\w*)", re.IGNORECASE)
_ITEM = re.compile(r"(?:\[[^\]]*\])?\s*(?:=\s*(?:\{[^}]*\}|\"[^\"]*\"|[^,;]*))?")
# Words that open an instruction: behind one of them no name comes into being.
_OPENERS = listed(
    "IF ELSE ENDIF WHILE ENDWHILE FOR ENDFOR LOOP ENDLOOP REPEAT UNTIL SWITCH CASE DEFAULT ENDSWITCH GOTO RETURN HALT "
    "EXIT WAIT PTP LIN CIRC SPTP SLIN SCIRC SPL PTP_REL LIN_REL CIRC_REL DEF DEFFCT DEFDAT END ENDFCT ENDDAT TRIGGER "
    "INTERRUPT ENUM STRUC EXT EXTFCT IMPORT CONTINUE BRAKE RESUME PULSE GLOBAL DECL CONST SIGNAL "
    "TIME_BLOCK CONST_VEL"
)


class KrlLayout(BlockLayout):
    opens = re.compile(
        r"(?:IF\b.*\bTHEN\b|FOR\b|WHILE\b|LOOP\b|REPEAT\b|SWITCH\b|SPLINE\b|PTP_SPLINE\b)", re.IGNORECASE
    )
    closes = re.compile(r"(?:ENDIF|ENDFOR|ENDWHILE|ENDLOOP|UNTIL|ENDSWITCH|ENDSPLINE)\b", re.IGNORECASE)
    between = re.compile(r"(?:ELSE|CASE|DEFAULT)\b", re.IGNORECASE)
    kept = re.compile(r"[&;]")  # records, comments and folds, which the controller's forms look for
    free_outside = True


class KrlTokens(Words):
    layout = KrlLayout()
    passed_over = r""";.*|^\s*&.*|"[^"]*\""""
    identifier = r"(?<![\w$#.])([A-Z_$][\w$]*)"
    keywords = _OPENERS | listed("TO STEP THEN DO IN OUT SEC AND OR NOT EXOR B_AND B_OR TRUE FALSE PUBLIC")
    patterns = (
        Pattern(
            TokenKind.ROUTINE,
            r"^\s*(?:GLOBAL\s+)?DEF(?:FCT\s+\w+(?:\[[^\]]*\])?)?\s+([A-Z_]\w*)(?=\s*\()",
            defines=True,
        ),
        Pattern(TokenKind.LABEL, r"^\s*([A-Z_]\w*)(?=\s*:\s*(?:;|$))", defines=True, local=True),
        Pattern(TokenKind.LABEL, r"\bGOTO\s+([A-Z_]\w*)", local=True),
        Pattern(TokenKind.SIGNAL, r"(\$(?:IN|OUT|ANIN|ANOUT)\[\d+\])"),
        Pattern(TokenKind.FRAME, r"\b(BASE_DATA\[\d+\])(?=\s*=)", defines=True),
        Pattern(TokenKind.TOOL, r"\b(TOOL_DATA\[\d+\])(?=\s*=)", defines=True),
        Pattern(TokenKind.FRAME, r"\b(BASE_DATA\[\d+\])"),
        Pattern(TokenKind.TOOL, r"\b(TOOL_DATA\[\d+\])"),
    )

    def declared(self, line: str) -> Iterator[tuple[int, TokenKind]]:
        signal = _SIGNAL.match(line)
        if signal is not None:
            yield signal.start(1), TokenKind.SIGNAL
            return
        match = _LINE.match(line)
        if match is None or match[1].upper() in _OPENERS:
            return
        kind = _KINDS.get(match[1].upper(), TokenKind.VARIABLE)
        yield match.start(2), kind
        place = match.end(2)
        while True:
            item = _ITEM.match(line, place)
            following = _NEXT.match(line, item.end() if item else place)
            if following is None:
                return
            yield following.start(1), kind
            place = following.end(1)


TOKENS = KrlTokens()
