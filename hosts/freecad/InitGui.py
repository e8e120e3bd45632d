# Runs when FreeCAD starts with a screen: the workbench, its commands and its tool bar.

import FreeCADGui


class OlpWorkbench(FreeCADGui.Workbench):
    """Robot programs with their times. FreeCAD runs this file without a name of its own: all is imported inside."""

    def __init__(self):
        import os

        import olp_freecad

        folder = os.path.dirname(os.path.dirname(olp_freecad.__file__))
        self.__class__.MenuText = "olp"
        self.__class__.ToolTip = "Robot programs: times, path, changes"
        self.__class__.Icon = os.path.join(folder, "resources", "olp.svg")

    def Initialize(self):  # noqa: N802
        from olp_freecad.gui import commands

        names = commands.register()
        self.appendToolbar("olp", names)
        self.appendMenu("olp", names)

    def GetClassName(self):  # noqa: N802
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(OlpWorkbench())
