"""File → Import → Robot program: the path, the tool and its times, as olp says them."""

from pathlib import Path

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)
from bpy_extras.io_utils import ImportHelper, poll_file_object_drop

from . import scene
from .ask import Olp, OlpError, told

SUFFIXES = [".jbi", ".src", ".mod", ".prg", ".ls", ".script"]


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    command: StringProperty(
        name="olp",
        description="The command olp: a name on the path, or a file",
        default="olp",
        subtype="FILE_PATH",
    )
    timeout_s: FloatProperty(
        name="Time limit", description="Longest time that olp may take, in seconds", default=300.0, min=1.0
    )

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(self, "command")
        self.layout.prop(self, "timeout_s")


def olp_of(context) -> Olp:
    preferences = context.preferences.addons[__package__].preferences
    return Olp(bpy.path.abspath(preferences.command) or "olp", preferences.timeout_s)


def whole(path: str) -> str:
    """A path as Blender writes it (// is beside the file that is open), from the root."""
    return str(Path(bpy.path.abspath(path)).resolve())


_robots: dict[str, list[str]] = {}  # olp's command: its robots


def known_robots(self, context, typed) -> list[str]:
    olp = olp_of(context)
    if olp.command not in _robots:
        try:
            _robots[olp.command] = olp.robots()
        except OlpError:
            return []
    return [name for name in _robots[olp.command] if typed.lower() in name]


class ImportRobotProgram(bpy.types.Operator, ImportHelper):
    """Import robot programs: the path and the tool, moving as long as olp says that they take"""

    bl_idname = "import_scene.robot_program"
    bl_label = "Import Robot Program"
    bl_options = {"REGISTER", "UNDO", "PRESET"}  # noqa: RUF012

    filter_glob: StringProperty(default=";".join(f"*{suffix}" for suffix in SUFFIXES), options={"HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    robot: StringProperty(
        name="Robot",
        description="A name of olp robots, or a robot file; empty: the one that olp.toml or the program names",
        search=known_robots,
        search_options={"SUGGESTION"},
    )
    signature: StringProperty(
        name="Signature", description="The robot's timing signature, a file that olp calibrate made"
    )
    colour: EnumProperty(name="Colour", items=scene.COLOUR_ITEMS, default="SPEED")
    per_frame: IntProperty(
        name="Points per Frame",
        description="Of the path; the tool has a key at every frame",
        default=8,
        min=1,
        max=100,
    )
    markers: BoolProperty(name="Markers", description="A marker where each line begins", default=True)
    fit: BoolProperty(
        name="Fit End", description="The scene ends with the longest of these programs", default=True
    )

    def execute(self, context):
        names = [file.name for file in self.files if file.name]
        paths = [Path(whole(self.directory), name) for name in names] or [Path(whole(self.filepath))]
        options = []
        if self.robot:
            options.append(f"--robot={whole(self.robot) if self.robot.endswith('.toml') else self.robot}")
        if self.signature:
            options.append(f"--signature={whole(self.signature)}")
        olp, roots, refused = olp_of(context), [], []
        dt_s = 1 / (scene.frame_rate(context.scene) * self.per_frame)
        for path in paths:
            try:
                answer = olp.time(path, options)
                rows = olp.track(path, dt_s, options)
            except OlpError as problem:
                refused.append(str(problem))
                continue
            roots.append(scene.build(context, path, answer, rows, self.per_frame, self.colour, self.markers))
            for diagnostic in answer["diagnostics"]:
                if diagnostic["severity"] == "warning":
                    self.report({"WARNING"}, told(diagnostic))
            self.report({"INFO"}, f"{path.name}: {answer['total_s']:.3f} s")
        if roots:
            if self.fit:
                context.scene.frame_end = max(map(scene.last_frame, roots))
            for thing in context.selected_objects:
                thing.select_set(False)
            context.view_layer.objects.active = roots[-1]
            for root in roots:
                root.select_set(True)
        if refused:
            self.report({"ERROR"}, "\n".join(refused))
        return {"FINISHED"} if roots else {"CANCELLED"}

    def invoke(self, context, event):
        return self.invoke_popup(context)


class DropRobotProgram(bpy.types.FileHandler):
    bl_idname = "IMPORT_SCENE_FH_robot_program"
    bl_label = "Robot program"
    bl_import_operator = ImportRobotProgram.bl_idname
    bl_file_extensions = ";".join(SUFFIXES)

    @classmethod
    def poll_drop(cls, context):
        return poll_file_object_drop(context)


class RobotProgramPanel(bpy.types.Panel):
    """The program of the active object, and the line that runs now"""

    bl_idname = "VIEW3D_PT_robot_program"
    bl_label = "Robot Program"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "olp"

    @classmethod
    def poll(cls, context):
        return scene.root_of(context.active_object) is not None

    def draw(self, context):
        root = scene.root_of(context.active_object)
        layout = self.layout
        layout.label(text=f"{root.name}: {root['olp_total_s']:.3f} s, {root['olp_robot'] or 'no robot'}")
        if abs(scene.frame_rate(context.scene) - root["olp_frames_per_s"]) > 1e-6:
            layout.label(text=f"Made for {root['olp_frames_per_s']:g} frames/s: import it anew", icon="ERROR")
        layout.prop(root, "olp_colour")
        low, high, unit = root["olp_scale_low"], root["olp_scale_high"], root["olp_scale_unit"]
        layout.label(text=f"Violet {low:.4g} {unit}, yellow {high:.4g} {unit}")
        segment = scene.segment_at(root, context.scene.frame_current_final)
        if segment:
            layout.separator()
            layout.label(text=f"{segment['line']}  {segment['statement']}")
            layout.label(text=f"{segment.get('duration_s', 0.0):.3f} s  {segment.get('limited_by', '')}")


def menu(self, context):
    self.layout.operator(ImportRobotProgram.bl_idname, text="Robot program (.jbi .src .mod .ls .script)")


CLASSES = (Preferences, ImportRobotProgram, DropRobotProgram, RobotProgramPanel)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.olp_colour = EnumProperty(
        name="Colour", items=scene.COLOUR_ITEMS, update=lambda root, context: scene.recolour(root)
    )
    bpy.types.TOPBAR_MT_file_import.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu)
    del bpy.types.Object.olp_colour
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
