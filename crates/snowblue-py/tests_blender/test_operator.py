"""The operator that bakes beside Blender, with what stands for its window."""

import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from test_blender import bake, block, lamp
from test_jobs import everything, flux

import snowblue.blender
from snowblue.blender import _panel


class Window:
    """What the operator uses of a window, and else the context of Blender."""

    def __init__(self):
        self.timers, self.status = 0, None
        self.window_manager = self.workspace = self.window = self
        self.windows = []

    def event_timer_add(self, interval, window):
        self.timers += 1
        return self

    def event_timer_remove(self, timer):
        self.timers -= 1

    def modal_handler_add(self, operator):
        pass

    def status_text_set(self, text):
        self.status = text

    def __getattr__(self, name):
        return getattr(bpy.context, name)


class Operator:
    """Has the methods of the operator, and keeps what it reports."""

    def __init__(self):
        self.reports = []

    def report(self, kind, text):
        self.reports.append((*kind, text))

    def __getattr__(self, name):
        if name not in vars(_panel.SnowBake):
            raise AttributeError(name)
        return vars(_panel.SnowBake)[name].__get__(self, type(self))


@pytest.fixture
def window(monkeypatch):
    app = SimpleNamespace(background=False, is_job_running=bpy.app.is_job_running)
    monkeypatch.setattr(_panel, "bpy", SimpleNamespace(app=app, context=bpy.context, types=bpy.types, utils=bpy.utils))
    return Window()


def event(kind, value="NOTHING"):
    return SimpleNamespace(type=kind, value=value)


def ended(operator, window):
    """What the operator gives at the end, by its timer."""
    while True:
        outcome = operator.modal(window, event("TIMER"))
        if outcome not in ({"PASS_THROUGH"}, {"RUNNING_MODAL"}):
            assert _panel._running is None and window.timers == 0 and window.status is None
            return outcome
        assert _panel._running is not None and window.timers == 1
        time.sleep(0.02)


def begun(window):
    operator = Operator()
    assert operator.invoke(window, None) == {"RUNNING_MODAL"} and window.timers == 1
    return operator


def test_the_operator_bakes_beside_blender(scene, window):
    thing = block()
    lamp()
    operator = begun(window)
    assert not bpy.ops.snowblue.bake.poll()
    assert operator.modal(window, event("MOUSEMOVE")) == {"PASS_THROUGH"}
    assert ended(operator, window) == {"FINISHED"}
    [baked] = [one for one in bpy.data.objects if one.snowblue.source]
    assert operator.reports == [("INFO", f"baked 1 object of snow with {len(baked.data.vertices):,} points")]
    # It is selected instead of the original, which is hidden.
    assert thing.hide_render and baked.select_get() and bpy.context.view_layer.objects.active == baked
    light = flux(baked)
    assert bpy.ops.snowblue.bake("EXEC_DEFAULT") == {"FINISHED"}
    assert np.array_equal(flux(baked), light)


def test_esc_stops_the_operator(scene, window):
    block()
    lamp()
    scene.snowblue_bake.step_mm, scene.snowblue_bake.field_step_mm = 4.0, 2.0
    before = everything()
    operator = begun(window)
    operator.modal(window, event("TIMER"))
    assert window.status is not None
    assert operator.modal(window, event("ESC", "PRESS")) == {"RUNNING_MODAL"}
    assert ended(operator, window) == {"CANCELLED"} and everything() == before
    assert operator.reports == [("INFO", "the bake was stopped, and no baked object was changed")]


def test_no_event_passes_while_the_operator_reads_frames(scene, window):
    block()
    lamp()
    scene.frame_end, scene.snowblue_bake.use_frames = 3, True
    operator = begun(window)
    for _ in range(2):
        assert operator.modal(window, event("LEFTMOUSE", "PRESS")) == {"RUNNING_MODAL"}
        operator.modal(window, event("TIMER"))
    assert operator.modal(window, event("LEFTMOUSE", "PRESS")) == {"PASS_THROUGH"}
    assert ended(operator, window) == {"FINISHED"}
    [(kind, text)] = operator.reports
    assert kind == "INFO" and text.endswith("points at 3 frames")


def test_errors_of_the_operator(scene, window, monkeypatch):
    thing = block()
    operator = Operator()
    assert operator.invoke(window, None) == {"CANCELLED"} and window.timers == 0 and _panel._running is None
    assert operator.reports == [("ERROR", "the scene has no lamp: add one, or give the World a colour")]
    lamp()
    operator = begun(window)
    bpy.data.objects.remove(thing)
    assert ended(operator, window) == {"CANCELLED"}
    # A warning names the object.
    assert operator.reports == [
        ("WARNING", "'block' was removed while it was baked: it has no light of this bake"),
        ("ERROR", "the snow was changed or removed while it was baked: bake again"),
    ]
    # After an error of the add-on itself, another bake is possible.
    block()
    operator = begun(window)
    monkeypatch.setattr(_panel.BakeJob, "finish", lambda job: {}["missing"])
    with pytest.raises(KeyError, match="missing"):
        ended(operator, window)
    assert _panel._running is None and window.timers == 0 and bpy.ops.snowblue.bake.poll()


def test_a_bake_ends_in_object_mode(scene, window):
    block()
    lamp()
    bpy.ops.mesh.primitive_cube_add(location=(5, 5, 5))
    operator = begun(window)
    bpy.ops.object.mode_set(mode="EDIT")
    while not operator.job.is_done:
        time.sleep(0.02)
    for _ in range(2):
        assert operator.modal(window, event("TIMER")) == {"PASS_THROUGH"}
    assert operator.job.progress == (1, "solved, waits for Object Mode")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert ended(operator, window) == {"FINISHED"}


def test_no_bake_begins_while_a_render_runs(scene, window, monkeypatch):
    block()
    lamp()
    monkeypatch.setattr(_panel.bpy.app, "is_job_running", lambda kind: kind == "RENDER")
    operator = Operator()
    assert operator.invoke(window, None) == {"CANCELLED"} and _panel._running is None
    assert operator.reports == [("ERROR", "a render is running: bake after it")]


def test_the_timer_ends_with_the_add_on(scene, window, monkeypatch):
    block()
    lamp()
    begun(window)
    monkeypatch.setattr(_panel.bpy, "context", window)
    snowblue.blender.unregister()
    assert window.timers == 0 and _panel._running is None
    monkeypatch.undo()
    snowblue.blender.register()


def test_a_baked_object_of_an_excluded_collection_is_not_selected(scene, window):
    thing = block()
    lamp()
    [baked] = bake()
    thing.hide_viewport = False
    collection = bpy.data.collections.new("excluded")
    scene.collection.children.link(collection)
    scene.collection.objects.unlink(baked)
    collection.objects.link(baked)
    bpy.context.view_layer.layer_collection.children["excluded"].exclude = True
    thing.select_set(True)
    assert ended(begun(window), window) == {"FINISHED"} and not baked.select_get()


def test_closing_blender_ends_the_operator(scene, window):
    block()
    lamp()
    operator = begun(window)
    operator.cancel(window)
    assert operator.job.is_done and _panel._running is None and window.timers == 0
    assert len(bake()) == 1
