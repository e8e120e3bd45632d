"""Short programs as text, and what `convert` makes of them."""

from olp.core.source import decode
from olp.fluent import read_source
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link
from olp.transpile.receipt_text import as_text

ROBOT = load_robot("yaskawa/gp25")
NAMES = {
    "inform": "part.jbi",
    "krl": "part.src",
    "rapid": "part.mod",
    "tp": "part.ls",
    "urscript": "part.script",
}
VENDORS = tuple(
    NAMES
)  # of these tests, whose programs ask for much; every other language has the contract suite


def read(text, vendor):
    name = NAMES.get(vendor, "part")
    program = read_source(decode(text.encode("cp1252"), name), vendor=vendor)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    return link(program).program


def converted(text, vendor, target, on_loss="comment"):
    return convert(read(text, vendor), target, Context(robot=ROBOT, on_loss=on_loss), date="2026/01/01 00:00")


def translated(text, vendor, target):
    return b"\n".join(converted(text, vendor, target).files.values()).decode("cp1252")


def run_elsewhere(text, vendor, target):
    """The plan of the translation, read again."""
    return run_converted(converted(text, vendor, target), target, ROBOT, read(text, vendor))


def assert_proven(receipt, *but):
    """As the receipt tells it: no run has a difference, not one that it names either, and nothing else stands against
    it but objections of the kinds `but`, each of which it has. What a plain run leaves out for values that no file
    tells ("uncompared") has to be compared in the runs with made-up ones, to their end.
    """
    assert {one.kind for one in receipt.verdict.objections} == set(but), as_text(receipt)
    plain = () if receipt.comparison is None else (receipt.comparison,)
    for one in (*plain, *receipt.again, *receipt.starts.values(), *receipt.made_up):
        assert not one.found, as_text(receipt)
    for one in receipt.made_up:
        assert not one.until, as_text(receipt)
        assert not one.unknown, as_text(receipt)


def module(*rows, data=()):
    return "\r\n".join(["MODULE M", *data, "PROC main()", *rows, "ENDPROC", "ENDMODULE", ""])


def krl(*rows):
    return "\r\n".join(["DEF PART ( )", *rows, "END", ""])


def inform(*rows, points=()):
    taught, variables = (sum(row.startswith(letter) for row in points) for letter in "CP")
    head = ["/JOB", "//NAME PART", "//POS", f"///NPOS {taught},0,0,{variables},0,0"]
    head += [*points, "//INST", "///DATE 2026/03/02 14:07", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    return "\r\n".join([*head, *rows, "END", ""])


def script(*rows):
    return "\n".join(["def part():", *(f"  {row}" for row in rows), "end", ""])


def tp(*rows, positions=()):
    """`positions`: number, UF, UT and the six values [mm, deg] of each."""
    head = ["/PROG  PART", "/ATTR", "DEFAULT_GROUP\t= 1,*,*,*,*;", "/APPL", "/MN"]
    head += [f"{number:4d}:{row} ;" for number, row in enumerate(rows, 1)]
    head.append("/POS")
    for number, user, tool, *values in positions:
        x, y, z, w, p, r = values
        head += [
            f"P[{number}]{{", "   GP1:", f"\tUF : {user}, UT : {tool},\t\tCONFIG : 'N U T, 0, 0, 0',",
            f"\tX = {x:.3f}  mm,\tY = {y:.3f}  mm,\tZ = {z:.3f}  mm,",
            f"\tW = {w:.3f} deg,\tP = {p:.3f} deg,\tR = {r:.3f} deg", "};",
        ]  # fmt: skip
    return "\n".join([*head, "/END", ""])
