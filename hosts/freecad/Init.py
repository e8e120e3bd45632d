# Runs when FreeCAD starts, with and without a screen: which files it opens by olp.

import FreeCAD

for title, suffixes in (
    ("Robot program, INFORM", "*.jbi"),
    ("Robot program, KRL", "*.src *.sub"),
    ("Robot program, RAPID", "*.mod *.modx *.prg"),
    ("Robot program, TP", "*.ls"),
    ("Robot program, URScript", "*.script *.urscript"),
):
    FreeCAD.addImportType(f"{title} ({suffixes})", "olp_freecad.importer")
