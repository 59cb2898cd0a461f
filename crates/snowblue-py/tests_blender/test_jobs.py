"""Bakes beside Blender: by steps, on another thread, stopped, and with a scene that changes meanwhile."""

import time

import bpy
import numpy as np
import pytest
from test_blender import COARSE, bake, block, lamp, world

import snowblue.blender
from snowblue.blender import _panel
from snowblue.blender._bake import BakeJob, Stopped
from snowblue.blender._solve import Options

FINE = Options(step_mm=4.0, field_step_mm=2.0)
"""Takes about 2 s for a lamp on two cores, so that there is time to stop it."""


def flux(thing, name="snow_lamp_0"):
    data = thing.data.attributes[name].data
    values = np.empty(3 * len(data), np.float32)
    data.foreach_get("vector", values)
    return values.reshape(-1, 3)


def started(options=Options(**COARSE), frames=None, objects=None):
    job = BakeJob(bpy.context.scene, objects, options, frames)
    while not job.is_collected:
        job.collect()
    job.start()
    return job


def waited(job):
    while not job.is_done:
        time.sleep(0.02)
    return job


def everything():
    kinds = (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.collections, bpy.data.node_groups)
    return [one.name for kind in (*kinds, bpy.data.scenes, bpy.data.images, bpy.data.worlds) for one in kind]


def test_a_bake_on_a_thread_is_that_at_once(scene):
    block()
    lamp()
    world((0.5, 0.5, 0.5))
    [baked] = snowblue.blender.bake()
    names = ("snow_lamp_0", "snow_sky")
    at_once = [flux(baked, name) for name in names]
    snowblue.blender.clear()
    job, seen = started(Options()), []
    while not job.is_done:
        seen.append(job.progress)
        # Blender goes on.
        bpy.context.view_layer.update()
        time.sleep(0.005)
    [baked] = job.finish()
    assert all(np.array_equal(flux(baked, name), values) for name, values in zip(names, at_once))
    parts = [part for part, _ in seen]
    assert parts == sorted(parts) and parts[0] < 0.5 and job.progress[0] == 1
    assert {label.split(":")[0] for _, label in seen} >= {"lamp 'lamp'", "the World"}


def test_nothing_stays_of_a_bake_that_is_stopped(scene):
    thing = block()
    lamp()
    before = everything()
    job = started(FINE)
    assert not job.is_done
    start = time.monotonic()
    job.stop(waits=True)
    # The thread looks every 50 ms, here beside those of other tests.
    assert job.is_done and time.monotonic() - start < 1
    with pytest.raises(Stopped):
        job.finish()
    assert everything() == before and not thing.hide_render
    assert len(bake()) == 1


def test_a_bake_stops_while_it_reads_frames(scene):
    block()
    lamp()
    scene.frame_set(7)
    job = BakeJob(scene, None, Options(), range(1, 4))
    job.collect()
    assert not job.is_collected and not job.is_done and job.progress == (1 / 3, "read frame 1")
    assert scene.frame_current == 7
    job.stop()
    assert job.is_done
    with pytest.raises(Stopped):
        job.finish()


def test_errors_of_the_solution_come_at_the_end(scene):
    block().snowblue.body = block(position=(0.1, 0, 0.1)).snowblue.body = "one"
    bpy.data.objects["block"].snowblue.preset = "FRESH"
    lamp()
    job = waited(started())
    with pytest.raises(ValueError, match="several materials") as caught:
        job.finish()
    with pytest.raises(ValueError, match="several materials") as at_once:
        bake()
    assert str(caught.value) == str(at_once.value)


def edited(thing):
    thing.data.vertices[0].co.x -= 0.01
    thing.data.update()


@pytest.mark.parametrize(
    "change, words",
    [
        (edited, "'block' was changed while"),
        (lambda thing: setattr(thing.modifiers.new("round", "BEVEL"), "width", 0.01), "'block' was changed"),
        (lambda thing: bpy.data.objects.remove(thing), "'block' was removed while"),
        (lambda thing: setattr(thing.snowblue, "is_snow", False), "'block' was marked as no snow while"),
    ],
    ids=["mesh", "modifier", "removed", "no snow"],
)
def test_snow_that_changes_during_a_bake_is_left(scene, change, words):
    thing, other = block(), block(position=(0.5, 0, 0.1))
    lamp()
    job = waited(started())
    change(thing)
    with pytest.warns(UserWarning, match=words):
        [baked] = job.finish()
    assert baked.snowblue.source == other and len([one for one in bpy.data.objects if one.snowblue.source]) == 1
    # A bake of that snow alone has no result.
    job = waited(started(objects=[other]))
    edited(other)
    before = everything()
    with pytest.warns(UserWarning), pytest.raises(ValueError, match="the snow was changed or removed"):
        job.finish()
    assert everything() == before


def test_snow_that_moves_during_a_bake_takes_its_light_along(scene):
    thing = block()
    lamp()
    [baked] = bake()
    places, light = [tuple(one.co) for one in baked.data.vertices], flux(baked)
    job = waited(started())
    thing.location.x, thing.rotation_euler.z = 3.0, 1.0
    assert job.finish() == [baked]
    assert [tuple(one.co) for one in baked.data.vertices] == places and np.array_equal(flux(baked), light)


def test_lamps_that_are_removed_during_a_bake_are_left_out(scene):
    block()
    one, other = lamp(), lamp(position=(0.4, 0.5, 0.3))
    [baked] = bake()
    light = flux(baked, "snow_lamp_1")
    job = waited(started())
    bpy.data.objects.remove(one)
    with pytest.warns(UserWarning, match="lamp 'lamp' was removed"):
        job.finish()
    assert np.array_equal(flux(baked), light) and "snow_lamp_1" not in baked.data.attributes
    job = waited(started())
    bpy.data.objects.remove(other)
    with pytest.warns(UserWarning), pytest.raises(ValueError, match="the lamps were removed"):
        job.finish()


@pytest.mark.parametrize("how", ["nodes", "type"])
def test_lamps_that_change_in_kind_during_a_bake_are_left_out(scene, how):
    block()
    one, other = lamp(), lamp(position=(0.4, 0.5, 0.3))
    [baked] = bake()
    light = flux(baked, "snow_lamp_1")
    job = waited(started())
    if how == "type":
        one.data.type = "SUN"
    else:
        one.data.use_nodes = True
        one.data.node_tree.nodes.clear()
    with pytest.warns(UserWarning, match="lamp 'lamp' was changed in its type, Normalize or nodes"):
        job.finish()
    assert np.array_equal(flux(baked), light) and "snow_lamp_1" not in baked.data.attributes


def test_another_frame_during_a_bake_does_no_harm(scene):
    """A mesh that deforms is compared at the frame of the bake."""
    thing = block()
    thing.shape_key_add(name="basis")
    key = thing.shape_key_add(name="tall")
    key.data[0].co.z -= 0.2
    for frame in (1, 10):
        key.value = (frame - 1) / 9
        key.keyframe_insert("value", frame=frame)
    lamp()
    scene.frame_set(1)
    with pytest.warns(UserWarning, match="of frame 1"):
        job = waited(started())
    scene.frame_set(10)
    assert len(job.finish()) == 1 and scene.frame_current == 10


def test_an_undo_during_a_bake_does_no_harm(scene):
    bpy.context.preferences.edit.use_global_undo = True
    block()
    lamp()
    bpy.ops.ed.undo_push(message="block")
    bpy.ops.mesh.primitive_cube_add(location=(5, 5, 5))
    bpy.ops.ed.undo_push(message="cube")
    job = waited(started())
    assert bpy.ops.ed.undo() == {"FINISHED"} and len(bpy.data.objects) == 2
    [baked] = job.finish()
    assert baked.snowblue.source.name == "block"


def test_a_removed_scene_ends_a_bake(scene):
    other = bpy.data.scenes.new("other")
    for thing in (block(), lamp()):
        other.collection.objects.link(thing)
    job = BakeJob(other, None, Options(**COARSE))
    job.collect()
    job.start()
    waited(job)
    bpy.data.scenes.remove(other)
    with pytest.raises(ValueError, match="the scene was removed"):
        job.finish()


def test_without_a_window_the_operator_bakes_at_once(scene):
    thing = block()
    lamp()
    assert bpy.ops.snowblue.bake("INVOKE_DEFAULT") == {"FINISHED"} and thing.hide_render
    assert not bpy.ops.snowblue.stop.poll()


def test_a_bake_ends_with_the_add_on(scene):
    block()
    lamp()
    job = _panel._running = started(FINE)
    snowblue.blender.unregister()
    assert job.is_done and _panel._running is None
    snowblue.blender.register()
    assert bpy.ops.snowblue.bake.poll()


def test_the_panel_offers_no_second_bake(scene, monkeypatch):
    block()
    lamp()
    job = started()
    monkeypatch.setattr(_panel, "_running", job)
    assert not bpy.ops.snowblue.bake.poll()
    assert bpy.ops.snowblue.stop() == {"FINISHED"}
    with pytest.raises(Stopped):
        waited(job).finish()
