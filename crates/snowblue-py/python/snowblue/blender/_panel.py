"""The panel "Snow" of the sidebar, and its operators."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import bpy

from snowblue.blender._bake import BakeJob, Stopped, clear
from snowblue.blender._closing import REMESH, fill_holes, local_mesh, open_edges, remesh
from snowblue.blender._settings import NUMBERS, SnowSettings, baked_of, is_snow, source_of
from snowblue.blender._solve import Options


INTERVAL_S = 0.1
"""Time between two looks at a bake."""
_running: BakeJob | None = None
"""The bake that runs beside Blender: at most one."""
_timer: bpy.types.Timer | None = None
"""What makes Blender look at it."""


class SnowBakeSettings(bpy.types.PropertyGroup):
    """How the snow of a scene is baked."""

    step_mm: bpy.props.FloatProperty(
        name="Step (mm)", description="Greatest length of an edge of the baked meshes; 0 selects it", min=0.0
    )
    field_step_mm: bpy.props.FloatProperty(
        name="Cells (mm)", description="Size of the cells that the snow is divided into; 0 selects it", min=0.0
    )
    max_bounces: bpy.props.IntProperty(
        name="Bounces", description="Surfaces over which light is followed into the snow", min=0, max=64, default=8
    )
    use_frames: bpy.props.BoolProperty(
        name="Frame Range", description="Bake each frame of the range of the scene, by its step"
    )


def _chosen(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The snow that is selected, itself or baked."""
    sources = dict.fromkeys(source_of(one) for one in context.selected_objects)
    return [one for one in sources if is_snow(one)]


def _reporting(operator: bpy.types.Operator, work: Callable[[], str]) -> set[str]:
    """Runs some work and tells the user of its result, its warnings and its error."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        kind, outcome = "INFO", "CANCELLED"
        try:
            result, outcome = work(), "FINISHED"
        except Stopped:
            result = "the bake was stopped, and no baked object was changed"
        except (ValueError, RuntimeError) as error:
            kind, result = "ERROR", str(error)
    for text in dict.fromkeys(str(one.message) for one in caught if one.category is UserWarning):
        operator.report({"WARNING"}, text)
    if result:
        operator.report({kind}, result)
    return {outcome}


class SnowMake(bpy.types.Operator):
    """Mark the selected meshes as snow"""

    bl_idname = "snowblue.make"
    bl_label = "Make Snow"
    bl_options = {"REGISTER", "UNDO"}

    close: bpy.props.EnumProperty(
        name="Close",
        description="What is done with meshes that have holes",
        items=[
            ("NONE", "Leave Open", "Open meshes do not become snow"),
            ("FILL", "Fill Holes", "New faces fill the holes. Normals are recalculated, all else of the mesh stays"),
            ("REMESH", "Voxel Remesh", f"A modifier '{REMESH}' makes a closed surface, without UV maps"),
        ],
        default="NONE",
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if not any(open_edges(*local_mesh(one)) for one in self._selected(context) if one.type == "MESH"):
            return self.execute(context)
        self.close = "FILL"
        return context.window_manager.invoke_props_dialog(self, title="The mesh is open. Close it?")

    def execute(self, context: bpy.types.Context) -> set[str]:
        selected = self._selected(context)
        wrong = [one for one in selected if one.type != "MESH"]
        if wrong or not selected:
            which = f"'{wrong[0].name}' is a {wrong[0].type.lower()}" if wrong else "nothing is selected"
            self.report({"ERROR"}, f"{which}, but snow must be a mesh")
            return {"CANCELLED"}
        return _reporting(self, lambda: self._make(selected))

    @staticmethod
    def _selected(context: bpy.types.Context) -> list[bpy.types.Object]:
        return [one for one in context.selected_objects if one.snowblue.source is None]

    def _make(self, selected: list[bpy.types.Object]) -> str:
        """Marks all of the objects as snow, or changes none."""
        undo = []
        try:
            for one in selected:
                count = open_edges(*local_mesh(one))
                if count and self.close == "NONE":
                    raise ValueError(
                        f"'{one.name}' has {count} open edges, but snow must be closed: choose Fill Holes or Voxel "
                        "Remesh"
                    )
                if count:
                    undo.append(fill_holes(one) if self.close == "FILL" else remesh(one))
        except ValueError:
            for restore in reversed(undo):
                restore()
            raise
        for one in selected:
            one.snowblue.is_snow = True
        return "1 object is snow" if len(selected) == 1 else f"{len(selected)} objects are snow"


class SnowUnmake(bpy.types.Operator):
    """Make the selected snow an ordinary object again"""

    bl_idname = "snowblue.unmake"
    bl_label = "No Snow"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(_chosen(context))

    def execute(self, context: bpy.types.Context) -> set[str]:
        chosen = _chosen(context)
        clear(context.scene, chosen)
        for one in chosen:
            one.snowblue.is_snow = False
        return {"FINISHED"}


class SnowBake(bpy.types.Operator):
    """Solve for the light in the selected snow, or in all if none is selected"""

    bl_idname = "snowblue.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _running is None

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Bakes at once, as scripts expect."""
        manager = context.window_manager

        def work() -> str:
            job = _job(context)
            while not job.is_collected:
                _read(job)
            job.solve(lambda done, total, _: manager.progress_update(done / total))
            return _finished(context, job)

        manager.progress_begin(0, 1)
        try:
            return _reporting(self, work)
        finally:
            manager.progress_end()

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Bakes beside Blender, which goes on."""
        global _running, _timer
        if bpy.app.background:
            return self.execute(context)
        self.job: BakeJob | None = None
        outcome = _reporting(self, lambda: self._begin(context))
        if self.job is None:
            return outcome
        _running = self.job
        _timer = context.window_manager.event_timer_add(INTERVAL_S, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        job = self.job
        if event.type == "ESC" and event.value == "PRESS":
            job.stop()
            return {"RUNNING_MODAL"}
        # The scene must not change while its frames are read.
        others = {"PASS_THROUGH"} if job.is_collected else {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return others
        try:
            outcome = _reporting(self, lambda: self._step(context))
        except BaseException:
            # Another bake must be possible.
            self.cancel(context)
            raise
        if outcome == {"FINISHED"} and not self.is_finished:
            # What is drawn all the time takes no clicks.
            if job.progress != self.shown:
                self.shown = job.progress
                context.workspace.status_text_set(_draw_status)
                _redraw(context)
            return others
        _end(context)
        return outcome

    def cancel(self, context: bpy.types.Context) -> None:
        """Ends the bake: Blender closes, or opens another file."""
        self.job.stop(waits=True)
        _end(context)

    def _begin(self, context: bpy.types.Context) -> str:
        job = _job(context)
        self.is_finished, self.shown = False, None
        self._collect(job)
        self.job = job
        return ""

    def _step(self, context: bpy.types.Context) -> str:
        """Reads a frame, looks at the solution, or makes the baked objects of it."""
        job = self.job
        if not job.is_collected and not job.is_stopping:
            self._collect(job)
        elif job.is_done and job.is_solved and context.mode != "OBJECT":
            # An undo step of another mode does not hold new objects.
            job.wait("solved, waits for Object Mode")
        elif job.is_done and not bpy.app.is_job_running("RENDER"):
            self.is_finished = True
            return _finished(context, job)
        return ""

    @staticmethod
    def _collect(job: BakeJob) -> None:
        _read(job)
        if job.is_collected:
            job.start()


def _read(job: BakeJob) -> None:
    """Reads the next frame of a bake. That renders the World, which fails during another render."""
    if bpy.app.is_job_running("RENDER"):
        raise ValueError("a render is running: bake after it")
    job.collect()


def _end(context: bpy.types.Context) -> None:
    """Takes away what shows the bake."""
    global _running, _timer
    _running = None
    if _timer is not None:
        context.window_manager.event_timer_remove(_timer)
        _timer = None
    context.workspace.status_text_set(None)
    _redraw(context)


def _job(context: bpy.types.Context) -> BakeJob:
    """The bake that the panel asks for."""
    scene = context.scene
    settings = scene.snowblue_bake
    options = Options(settings.step_mm or None, settings.field_step_mm or None, settings.max_bounces)
    frames = range(scene.frame_start, scene.frame_end + 1, scene.frame_step) if settings.use_frames else None
    return BakeJob(scene, _chosen(context) or None, options, frames)


def _finished(context: bpy.types.Context, job: BakeJob) -> str:
    """Makes the baked objects and says how many. They are selected where the originals were, which are hidden now."""
    selected, active = context.selected_objects, context.view_layer.objects.active
    baked = job.finish()
    # The view layer has new objects after an update.
    context.view_layer.update()
    for one in baked:
        if context.view_layer.objects.get(one.name) != one:
            # Its collection is excluded.
            continue
        if one.snowblue.source in selected:
            one.select_set(True)
        if one.snowblue.source == active and context.mode == "OBJECT":
            context.view_layer.objects.active = one
    points = sum(len(one.data.vertices) for one in baked)
    objects = "1 object" if len(baked) == 1 else f"{len(baked)} objects"
    frames = f" at {job.frame_count} frames" if job.frame_count > 1 else ""
    return f"baked {objects} of snow with {points:,} points{frames}"


def _draw_status(header: bpy.types.Header, context: bpy.types.Context) -> None:
    """The status bar while snow is baked."""
    if _running is not None:
        part, label = _running.progress
        header.layout.label(text=f"Snow: {label}")
        header.layout.progress(factor=part, text=f"{part:.0%}")
        header.layout.label(text="Stop the bake", icon="EVENT_ESC")
    header.layout.separator_spacer()
    header.layout.template_reports_banner()


def _redraw(context: bpy.types.Context) -> None:
    """Draws the panel anew."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type == "VIEW_3D" else ():
                if region.type == "UI":
                    region.tag_redraw()


class SnowStop(bpy.types.Operator):
    """Stop the bake. No baked object is changed"""

    bl_idname = "snowblue.stop"
    bl_label = "Stop"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _running is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        _running.stop()
        return {"FINISHED"}


class SnowClear(bpy.types.Operator):
    """Remove the baked objects of the selected snow, or all if none is selected, and show the originals"""

    bl_idname = "snowblue.clear"
    bl_label = "Clear"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return _reporting(self, lambda: f"removed {clear(context.scene, _chosen(context) or None)} baked objects")


class SnowPanel(bpy.types.Panel):
    """Snow of the selected objects"""

    bl_idname = "VIEW3D_PT_snowblue"
    bl_label = "Snow"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Snow"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        source = source_of(context.object) if context.object else None
        if source is not None and is_snow(source):
            settings = source.snowblue
            layout.label(text=source.name, icon="FREEZE")
            _draw_kind(layout, settings, "")
            layout.prop(settings, "body")
            layout.prop_search(settings, "painted", source, "vertex_groups")
            if settings.painted:
                _draw_kind(layout, settings, "painted_")
                for name in ("painted_soot_ng_g", "painted_dust_ng_g"):
                    layout.prop(settings, name)
        row = layout.row()
        row.operator(SnowMake.bl_idname)
        row.operator(SnowUnmake.bl_idname)
        settings = context.scene.snowblue_bake
        for name in ("step_mm", "field_step_mm", "max_bounces", "use_frames"):
            layout.prop(settings, name)
        if _running is not None:
            part, label = _running.progress
            layout.progress(factor=part, text=label)
            layout.operator(SnowStop.bl_idname, icon="CANCEL")
            return
        row = layout.row()
        row.scale_y = 1.5
        is_baked = source is not None and is_snow(source) and baked_of(source) is not None
        row.operator(SnowBake.bl_idname, text="Bake Again" if is_baked else "Bake")
        row.operator(SnowClear.bl_idname)


def _draw_kind(layout: bpy.types.UILayout, settings: SnowSettings, prefix: str) -> None:
    """The kind of snow and its numbers, whose names have a prefix."""
    layout.prop(settings, f"{prefix}preset")
    numbers = layout.column()
    numbers.enabled = getattr(settings, f"{prefix}preset") == "CUSTOM"
    for name in NUMBERS:
        numbers.prop(settings, prefix + name)


CLASSES = (SnowSettings, SnowBakeSettings, SnowMake, SnowUnmake, SnowBake, SnowStop, SnowClear, SnowPanel)


def register() -> None:
    """Adds the panel, the operators and the settings of objects and scenes to Blender, unless it has them."""
    if SnowSettings.is_registered:
        return
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Object.snowblue = bpy.props.PointerProperty(type=SnowSettings)
    bpy.types.Scene.snowblue_bake = bpy.props.PointerProperty(type=SnowBakeSettings)


def unregister() -> None:
    """Takes away what :func:`register` added. Settings stay in the files that have them."""
    if not SnowSettings.is_registered:
        return
    if _running is not None:
        _running.stop(waits=True)
        _end(bpy.context)
    del bpy.types.Scene.snowblue_bake
    del bpy.types.Object.snowblue
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
