"""Writes syntaxes/*.tmLanguage.json: the colours of the five languages, with the words of olp's own grammars.

`python hosts/vscode/colours.py` writes them anew; with `--check` it only says whether they are as they should be.
A word that a grammar of olp gains is coloured by itself; which words steer the program is said here.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
GRAMMARS = HERE.parent.parent / "grammars"

COMMENT = "comment.line"
STRING = "string.quoted"
NUMBER = "constant.numeric"
STATE = "constant.language"
FLOW = "keyword.control"
MOTION = "support.function.motion"
INSTRUCTION = "support.function.instruction"
OPERATOR = "keyword.operator"
STORAGE = "storage.type"
TAG = "variable.parameter"
SIGNAL = "support.variable.signal"
VARIABLE = "variable.other"
POINT = "variable.other.constant.point"
ROUTINE = "entity.name.function"
LABEL = "entity.name.label"
HEADER = "keyword.other.header"

Rule = dict[str, Any]


def words_of(language: str, *terminals: str) -> list[str]:
    """The words that these terminals of olp's grammar accept."""
    text = (GRAMMARS / f"{language}.lark").read_text(encoding="utf-8")
    found: list[str] = []
    for terminal in terminals:
        pattern = re.search(rf"^{terminal}(?:\.\d)?: /(.+)/i?$", text, re.M)
        assert pattern, f"{language}.lark has no terminal {terminal}"
        accepted = re.sub(r"\(\?[!=][^)]*\)", "", pattern[1]).replace("(?:", "(")
        found += alternatives(accepted)
    return found


def alternatives(pattern: str) -> list[str]:
    """The words of `A|B`, `(A|B)`, `C_(A|B)`; what is no plain word falls out."""
    whole = re.fullmatch(r"(\w*)\(([^()]*)\)(\w*)(?:\\b)?", pattern)
    before, inner, behind = (whole[1], whole[2], whole[3]) if whole else ("", pattern, "")
    words = (before + word.replace("\\b", "").replace("\\", "") + behind for word in inner.split("|"))
    return [word for word in words if re.fullmatch(r"[A-Za-z_][\w$ ]*", word)]


def literals_of(language: str) -> list[str]:
    """The words that stand in quotes in the rules of olp's grammar."""
    text = (GRAMMARS / f"{language}.lark").read_text(encoding="utf-8")
    rules = "\n".join(line for line in text.splitlines() if not re.match(r"\s*//|[A-Z_]+(?:\.\d)?:", line))
    return sorted(set(re.findall(r'"([A-Za-z_]{2,})"', rules)))


def rule(scope: str, match: str, language: str, **groups: str) -> Rule:
    made: Rule = {"match": match}
    if scope:
        made["name"] = f"{scope}.{language}"
    if groups:
        made["captures"] = {k[1:]: {"name": f"{v}.{language}"} for k, v in groups.items()}
    return made


def words(scope: str, found: Iterable[str], language: str, flags: str = "") -> Rule:
    listed = "|".join(re.escape(word) for word in sorted(set(found), key=lambda w: (-len(w), w)))
    return rule(scope, rf"{flags}(?<![\w$])(?:{listed})(?![\w$])", language)


def inform() -> list[Rule]:
    name = "inform"
    flow = [
        *words_of(name, "JUMP", "IF", "ELSEIF", "WHILE", "SUFFIX", "JOINT", "CASE", "TO"),
        *("CALL", "RET", "ELSE", "ENDIF", "ENDWHILE", "FOR", "NEXT", "SWITCH", "DEFAULT", "ENDSWITCH"),
        *("PAUSE", "NOP", "END", "WAIT", "TIMER", "PSTART", "PWAIT", "TSYNC", "MACRO1", "UNTIL", "STEP"),
    ]
    moves = words_of(name, "MOVE", "REFERENCE")
    other = words_of(
        name, "FUNCTION", "UPDATE", "SHIFT_ON", "SHIFT_OFF", "PROCESS", "CLEAR_WORD", "FOREXPRESS"
    )
    other += [word for word in literals_of(name) if word not in {*flow, *moves}]
    plain = words_of(name, "FRAME", "MTOOL", "END_OF_ARC", "NO_WAIT", "CONTINUOUS", "SYNC", "ALL", "LOCKED")
    return [
        rule("", r"^(//NAME|JOB:)\s*(\S.*)?$", name, _1=HEADER, _2=ROUTINE),
        rule("", r"^(///+[A-Z0-9]+)(.*)$", name, _1=HEADER, _2="string.unquoted.header"),
        rule(HEADER, r"^/JOB\b.*$|^//(?:POS|INST|ALIAS|ARGINFO)\b.*$", name),
        rule(COMMENT, r"(?:'|//).*$", name),
        rule(STRING, r'"[^"]*"', name),
        rule("", r"\b(JOB:)([^\s'\"]+)", name, _1=TAG, _2=ROUTINE),
        rule(LABEL, r"(?<=^|\s)\*[^\s'*]+", name),
        rule(SIGNAL, r"\b[A-Z]+#", name),
        rule(POINT, r"(?<!\w)(?:BC|EC|BP|EX|C|E|P)\d+(?!\w)", name),
        rule(
            VARIABLE, r"(?<!\w)(?:L?(?:PX|BP|EX|[BIDRSP])\d+|L?(?:PX|BP|EX|[BIDRSP])(?=\[)|\$\w+)(?!\w)", name
        ),
        rule(TAG, r"\b[A-Z][A-Z0-9]*(?:/[A-Z]+)?(?==)", name),
        words(MOTION, moves, name),
        words(FLOW, flow, name),
        words(INSTRUCTION, other, name),
        words(STATE, ["ON", "OFF", "LOW", "HIGH"], name),
        words(TAG, plain, name),
        rule(NUMBER, r"(?<![\w#])[+-]?(?:\d+\.?\d*|\.\d+)(?!\w)", name),
        rule(OPERATOR, r"<=|>=|<>|[<>=+*/-]", name),
    ]


def krl() -> list[Rule]:
    name, any_case = "krl", "(?i)"
    text = (GRAMMARS / "krl.lark").read_text(encoding="utf-8")
    quiet = [
        word for word in re.findall(r"^_([A-Z_]+)\.2", text, re.M) if word not in ("CA", "ENUM", "STRUC")
    ]
    storage = [
        "DEF",
        "DEFFCT",
        "DEFDAT",
        "SIGNAL",
        "ENUM",
        "STRUC",
        *words_of(name, "GLOBAL", "PUBLIC", "DECL", "CONST"),
    ]
    types = [
        "INT",
        "REAL",
        "BOOL",
        "CHAR",
        "POS",
        "E6POS",
        "AXIS",
        "E6AXIS",
        "FRAME",
        "LOAD",
        "FDAT",
        "PDAT",
        "LDAT",
    ]
    motion = [*words_of(name, "MOVE", "ARC", "RELATIVE", "RELATIVE_ARC", "BLOCK"), "ENDSPLINE", "TIME_BLOCK"]
    flow = [
        *(w for w in quiet if w not in {*storage, *motion, "PULSE"}),
        *words_of(name, "END"),
        "CONTINUE",
        "INTERRUPT",
    ]
    return [
        rule(HEADER, r"^&.*$", name),
        rule("comment.line.fold", r"(?i);\s*(?:END)?FOLD\b.*$", name),
        rule(COMMENT, r";.*$", name),
        rule(STRING, r'"[^"]*"', name),
        rule(NUMBER, r"(?i)'[BHD]?\s*[0-9A-F]+'", name),
        rule("", r"(?i)\b(DEF|DEFDAT)\s+(\w+)", name, _1=STORAGE, _2=ROUTINE),
        rule("", r"(?i)\b(DEFFCT)\s+(\w+)\s+(\w+)", name, _1=STORAGE, _2="entity.name.type", _3=ROUTINE),
        words(MOTION, motion, name, any_case),
        words(TAG, [*words_of(name, "BLEND"), "CA"], name, any_case),
        words(FLOW, flow, name, any_case),
        words(STORAGE, storage, name, any_case),
        words("entity.name.type", types, name, any_case),
        words(
            OPERATOR + ".word",
            words_of(name, "AND", "OR", "EXOR", "B_AND", "B_OR", "B_EXOR", "NOT"),
            name,
            any_case,
        ),
        words(STATE, words_of(name, "STATE"), name, any_case),
        words(INSTRUCTION, ["PULSE", "TRIGGER", "BAS", "ON_ERROR_PROCEED"], name, any_case),
        rule("constant.other.enum", r"#\s*\w+", name),
        rule(SIGNAL, r"(?i)\$(?:IN|OUT|ANIN|ANOUT)\b", name),
        rule("support.variable.system", r"\$\w+", name),
        rule(ROUTINE, r"\b[A-Za-z_]\w*(?=\s*\()", name),
        rule(NUMBER, r"(?<![\w$.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w$])", name),
        rule(OPERATOR, r"==|<>|<=|>=|[<>=+*/:-]", name),
    ]


def rapid() -> list[Rule]:
    name, any_case = "rapid", "(?i)"
    text = (GRAMMARS / "rapid.lark").read_text(encoding="utf-8")
    listed = re.search(r"^NAME: /\(\?!\(\?:([A-Z|]+)\)", text, re.M)
    assert listed, "rapid.lark lists its reserved words in NAME"
    reserved = listed[1].split("|")
    storage = [
        *words_of(name, "SCOPE", "STORAGE", "PASSING", "ENDROUTINE"),
        *("MODULE", "ENDMODULE", "PROC", "FUNC", "TRAP", "RECORD", "ENDRECORD", "ALIAS"),
        *("SYSMODULE", "NOSTEPIN", "VIEWONLY", "READONLY", "NOVIEW"),
    ]
    operators = ["AND", "OR", "NOT", "XOR", "DIV", "MOD"]
    flow = [word for word in reserved if word not in {*storage, *operators, "TRUE", "FALSE"}]
    moves = r"Move(?:Abs|Ext)?[JLC]\w*|Search[LC]|Trigg[JLC]\w*|(?:Arc|Disp|Spot|Cap|Paint)[LJC]\w*"
    begins = "|".join([*reserved, moves])
    return [
        rule(COMMENT, r"!.*$", name),
        {
            "begin": '"',
            "end": '"|$',
            "name": f"{STRING}.{name}",
            "patterns": [rule("constant.character.escape", '""', name)],
        },
        rule(HEADER, r"^\s*%%%|^\s*(?:VERSION|LANGUAGE):.*$", name),
        rule("", r"(?i)\b(MODULE|PROC|TRAP)\s+(\w+)", name, _1=STORAGE, _2=ROUTINE),
        rule("", r"(?i)\b(FUNC)\s+(\w+)\s+(\w+)", name, _1=STORAGE, _2="entity.name.type", _3=ROUTINE),
        rule(
            "",
            r"(?i)\b(CONST|PERS|VAR)\s+(\w+)\s+(\w+)",
            name,
            _1=STORAGE,
            _2="entity.name.type",
            _3=VARIABLE,
        ),
        rule(MOTION, rf"(?i)\b(?:{moves})\b", name),
        words(FLOW, flow, name, any_case),
        words(STORAGE, storage, name, any_case),
        words(OPERATOR + ".word", operators, name, any_case),
        words(STATE, words_of(name, "BOOLEAN"), name, any_case),
        rule("", r"(\\)(\w+)", name, _1=OPERATOR, _2=TAG),
        rule(POINT, r"(?i)\b(?:fine|z\d+|v\d+|vmax|vrot\d+|vlin\d+|tool0|wobj0|load0)\b", name),
        rule("", rf"(?i)^\s*(?!(?:{begins})\b)([A-Z]\w*)(?=\s+[\w\\\"]|\s*;)", name, _1=INSTRUCTION),
        rule(ROUTINE, r"\b[A-Za-z]\w*(?=\s*\()", name),
        rule(
            NUMBER,
            r"(?i)(?<!\w)(?:0x[0-9a-f]+|0b[01]+|0o[0-7]+|(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?)(?!\w)",
            name,
        ),
        rule(OPERATOR, r":=|<=|>=|<>|[<>=+*/-]", name),
    ]


def tp() -> list[Rule]:
    name = "tp"
    flow = [
        "IF",
        "THEN",
        "ELSE",
        "ENDIF",
        "SELECT",
        "FOR",
        "ENDFOR",
        "JMP",
        "CALL",
        "RUN",
        "WAIT",
        "TIMEOUT",
        "SKIP",
    ]
    flow += [
        "CONDITION",
        "END",
        "PAUSE",
        "ABORT",
        *words_of(name, "TO", "DOWNTO"),
        *german("WENN", "DANN", "SONST"),
    ]
    other = [
        "PULSE",
        "OVERRIDE",
        "PAYLOAD",
        "UALM",
        "MONITOR",
        "START",
        "STOP",
        "RESET",
        "UFRAME_NUM",
        "UTOOL_NUM",
        "MESSAGE",
    ]
    tags = ["FINE", "ACC", "Offset", "Tool_Offset", "INC", "COORD", "Wjnt", "PTH", "TA", "TB", "DB", "TIME"]
    return [
        rule("", r"^(/PROG)\s+(\S+)(.*)$", name, _1=HEADER, _2=ROUTINE, _3="string.unquoted.header"),
        rule(HEADER, r"^/(?:ATTR|APPL|MN|POS|END)\b.*$", name),
        rule("", r"^([A-Z_.][A-Za-z_. ]*?)\s*=(.*)$", name, _1=TAG, _2="string.unquoted.header"),
        rule("", r"^(\s*\d+\s*:)\s*((?:!|--eg:|//).*)$", name, _1="comment.other.line-number", _2=COMMENT),
        rule("comment.other.line-number", r"^\s*\d*\s*:(?!\s*\()", name),
        rule(MOTION, r"(?<![\w\[])[JLCAS](?=\s+PR?\[)", name),
        rule(
            "",
            r"(?<!\w)(PR?)(\[)(?:GP\d:)?(\d+)(:[^\]]*)?",
            name,
            _1=POINT,
            _3=NUMBER,
            _4="string.unquoted.name",
        ),
        rule(
            "",
            r"(?<!\w)((?:[DRGASUW][IO]|WS[IO]|F|M)(?=\[))(\[)(\d+)(:[^\]]*)?",
            name,
            _1=SIGNAL,
            _3=NUMBER,
            _4="string.unquoted.name",
        ),
        rule(
            "",
            r"(?<!\w)((?:AR|SR|R|TIMER|UFRAME|UTOOL)(?=\[))(\[)(\d+)(:[^\]]*)?",
            name,
            _1=VARIABLE,
            _3=NUMBER,
            _4="string.unquoted.name",
        ),
        rule("", r"(?<!\w)(LBL)(\[)(\w+)(:[^\]]*)?", name, _1=LABEL, _3=NUMBER, _4="string.unquoted.name"),
        rule(STRING, r"'[^'\r\n]*'|\"[^\"\r\n]*\"", name),
        rule("", r"\b(CALL|RUN)\s+([A-Za-z_*][\w-]*)", name, _1=FLOW, _2=ROUTINE),
        words(FLOW, flow, name),
        rule(TAG, r"\bC(?:NT|R|D)(?=\d|\s*R?\[|\b)", name),
        rule(TAG, r"\bACC(?=\d)", name),
        words(TAG, tags, name),
        words(INSTRUCTION, other, name),
        words(STATE, ["ON", "OFF", "LPOS", "JPOS"], name),
        words(OPERATOR + ".word", ["AND", "OR", "DIV", "MOD"], name),
        rule("support.variable.system", r"\$[A-Za-z0-9_$.]+", name),
        rule(
            "keyword.other.unit",
            r"(?<=\d|\]|\s)(?:mm/sec|cm/min|inch/min|deg/sec|msec|sec|mm|deg|%)(?!\w)",
            name,
        ),
        rule("", r"^\s*([A-Z]\d?)\s*=", name, _1=TAG),
        rule(NUMBER, r"(?<![\w$])(?:\d+\.?\d*|\.\d+)(?=mm|deg|sec|msec|cm|inch|%|\W|$)", name),
        rule(OPERATOR, r"<=|>=|<>|[<>=+*/-]", name),
    ]


def german(*found: str) -> list[str]:
    """Keywords of controllers that are set to German."""
    return [*found, "SPRUNG", "AUFRUF", "WARTE", "ENDE"]


def urscript() -> list[Rule]:
    name = "urscript"
    flow = ["if", "elif", "else", "while", "end", "return", "break", "continue", "join", "kill", "run"]
    moves = "move[jlpc]|optimovej|optimovel|servo[jc]|speed[jl]|stop[jl]|force_mode|freedrive_mode"
    return [
        rule("comment.line.node", r"^\s*\$\s*\d+.*$", name),
        rule(COMMENT, r"#.*$", name),
        rule(STRING, r'"[^"\r\n]*"', name),
        rule("", r"\b(def|thread|sec)\s+(\w+)", name, _1=STORAGE, _2=ROUTINE),
        rule(MOTION, rf"(?<![\w.])(?:{moves})(?=\s*\()", name),
        words(FLOW, flow, name),
        words(STORAGE, words_of(name, "DEFINE", "SCOPE"), name),
        words(OPERATOR + ".word", ["and", "or", "xor", "not"], name),
        words(STATE, ["True", "False", "true", "false"], name),
        rule(POINT, r"(?<!\w)p(?=\[)", name),
        rule(TAG, r"(?<=[(,])\s*[A-Za-z_]\w*(?=\s*=(?!=))", name),
        rule(
            "support.function.builtin",
            r"\b(?:set|get|modbus|socket|rpc|textmsg|popup|sleep|sync|pose|is|d2r|r2d)(?:_\w+)?(?=\s*\()",
            name,
        ),
        rule(ROUTINE, r"\b[A-Za-z_]\w*(?=\s*\()", name),
        rule(NUMBER, r"(?<![\w.])(?:0[xX][0-9A-Fa-f]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?!\w)", name),
        rule(OPERATOR, r"==|!=|<=|>=|[-+*/]=|[<>=+*/%!-]", name),
    ]


LANGUAGES = {"inform": inform, "krl": krl, "rapid": rapid, "tp": tp, "urscript": urscript}


def text_of(language: str) -> str:
    grammar = {"scopeName": f"source.{language}", "patterns": LANGUAGES[language]()}
    return json.dumps(grammar, indent=1, ensure_ascii=False) + "\n"


def main(arguments: list[str]) -> int:
    stale = []
    for language in LANGUAGES:
        file = HERE / "syntaxes" / f"{language}.tmLanguage.json"
        text = text_of(language)
        if file.exists() and file.read_text(encoding="utf-8") == text:
            continue
        stale.append(file.name)
        if "--check" not in arguments:
            file.write_text(text, encoding="utf-8", newline="\n")
    for name in stale:
        print(name, "is not as olp's grammars are" if "--check" in arguments else "written")
    return 1 if stale and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
