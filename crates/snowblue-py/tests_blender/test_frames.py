"""Bakes of several frames: one mesh for each, which geometry nodes show by the frame."""

import bpy
import numpy as np
import pytest
from test_blender import AHEAD, BEHIND, COARSE, FRONT, bake, block, inner, lamp, link, shot, world
from test_jobs import everything, flux

import snowblue.blender
import snowblue.blender._solve
from snowblue.blender._bake import BakeJob
from snowblue.blender._solve import Options


def shown(frame):
    """The mesh that is seen at a frame, evaluated, and where it is."""
    bpy.context.scene.frame_set(frame)
    seen = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        if instance.is_instance:
            mesh = instance.object.data
            places, values = np.empty(3 * len(mesh.vertices), np.float32), np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", places)
            mesh.attributes["snow_lamp_0"].data.foreach_get("vector", values)
            assert mesh.has_custom_normals
            seen.append((places.reshape(-1, 3), values.reshape(-1, 3), np.array(instance.matrix_world)))
    [seen] = seen
    return seen


def moving_lamp():
    light = lamp()
    for frame, x in ((1, 0.0), (5, 0.4)):
        light.location.x = x
        light.keyframe_insert("location", frame=frame)
    return light


@pytest.mark.filterwarnings("error::UserWarning")
def test_each_frame_has_the_light_of_its_own(scene):
    thing = block()
    moving_lamp()
    scene.frame_set(4)
    before = everything()
    [baked] = bake(frames=range(1, 6, 2))
    assert scene.frame_current == 4 and thing.hide_render
    frames = [shown(frame)[1] for frame in (-9, 1, 2, 3, 4, 5, 9)]
    # Before, between and after the frames that were baked, the last of them, or else the first, is shown.
    for number, same in ((0, 1), (2, 1), (4, 3), (6, 5)):
        assert np.array_equal(frames[number], frames[same])
    alone = []
    for frame in (1, 3, 5):
        scene.frame_set(frame)
        with pytest.warns(UserWarning, match=f"of frame {frame}"):
            assert bake() == [baked]
        assert not baked.modifiers and baked.snowblue.frames is None
        alone.append(flux(baked))
    for number, light in zip((1, 3, 5), alone):
        assert np.array_equal(frames[number], light)
    assert not np.array_equal(alone[0], alone[1])
    assert bake(frames=range(1, 3)) == [baked]
    assert snowblue.blender.clear() == 1 and everything() == before and not thing.hide_render


@pytest.mark.parametrize("position", [BEHIND, FRONT], ids=["dark", "lit"])
def test_pictures_of_frames_are_those_of_bakes_at_them(scene, tmp_path, position):
    block()
    moving_lamp().location[1:] = position[1:]
    [baked] = bake(frames=range(1, 6, 4))
    pictures = []
    for frame in (1, 5):
        scene.frame_set(frame)
        pictures.append(shot(tmp_path, AHEAD, samples=16))
    for frame, (picture, mask) in zip((1, 5), pictures):
        scene.frame_set(frame)
        with pytest.warns(UserWarning):
            bake()
        alone, _ = shot(tmp_path, AHEAD, samples=16)
        # The samples are the same, but an instance rounds to 32 bits at other places.
        np.testing.assert_allclose(picture[inner(mask)], alone[inner(mask)], rtol=1e-3, atol=1e-6)


def test_a_mesh_that_deforms_and_moves_is_that_of_each_frame(scene):
    thing = block()
    thing.shape_key_add(name="basis")
    key = thing.shape_key_add(name="tall")
    for point in key.data:
        point.co.z *= 2
    for frame in (1, 3):
        key.value, thing.location.x = (frame - 1) / 2, 0.1 * frame
        key.keyframe_insert("value", frame=frame)
        thing.keyframe_insert("location", frame=frame)
    lamp()
    bake(frames=range(1, 4, 2))
    heights = []
    for frame in (1, 3):
        places, _, matrix = shown(frame)
        heights.append(np.ptp(places[:, 2]))
        np.testing.assert_allclose(matrix[:3, 3], (0.1 * frame, 0, 0.1), atol=1e-6)
    np.testing.assert_allclose(heights, [1, 2], rtol=1e-5)


def test_what_stands_still_is_solved_for_once(scene, monkeypatch):
    block().vertex_groups.new(name="all").add(range(8), 0.5, "REPLACE")
    moving_lamp()
    lamp(position=(0.4, 0.5, 0.3))
    world((0.5, 0.5, 0.5))
    count = 0
    made = snowblue.blender._solve._baked

    def counted(*arguments):
        nonlocal count
        count += 1
        return made(*arguments)

    monkeypatch.setattr(snowblue.blender._solve, "_baked", counted)
    [baked] = bake(frames=range(1, 4))
    # Three for the lamp that moves, and one each for the other and the World.
    assert count == 5
    things = sorted(baked.snowblue.frames.objects, key=lambda one: one.name)
    assert len(things) == 3
    first, *rest = [flux(thing, "snow_lamp_1") for thing in things]
    assert all(np.array_equal(first, other) for other in rest)
    assert [tuple(thing.vertex_groups.keys()) for thing in things] == [("all",)] * 3
    assert all(len(thing.data.uv_layers) == 1 and len(thing.data.materials) == 1 for thing in things)


def test_a_lamp_may_be_hidden_at_a_frame(scene):
    block()
    one, other = lamp(), lamp(position=(0.4, 0.5, 0.3))
    for frame, is_hidden in ((1, False), (2, True)):
        one.hide_render = is_hidden
        one.keyframe_insert("hide_render", frame=frame)
    [baked] = bake(frames=range(1, 3))
    names = [
        {name for name in thing.data.attributes.keys() if name.startswith("snow_")}
        for thing in sorted(baked.snowblue.frames.objects, key=lambda thing: thing.name)
    ]
    both = [{f"snow_lamp_{number}", f"snow_lamp_{number}_irradiance"} for number in (0, 1)]
    assert names == [both[0] | both[1], both[1]]


def test_a_world_is_rendered_again_only_if_it_changes(scene, monkeypatch):
    block()
    world((0.5, 0.5, 0.5))
    rendered = []
    panorama = snowblue.blender._world._panorama
    monkeypatch.setattr(snowblue.blender._world, "_panorama", lambda *of: rendered.append(1) or panorama(*of))
    bake(frames=range(1, 4))
    assert len(rendered) == 1
    strength = scene.world.node_tree.nodes["Background"].inputs["Strength"]
    for frame, value in ((1, 1.0), (3, 3.0)):
        strength.default_value = value
        strength.keyframe_insert("default_value", frame=frame)
    [baked] = bake(frames=range(1, 4, 2))
    assert len(rendered) == 3
    first, last = [flux(baked.snowblue.frames.objects[number], "snow_sky") for number in (0, 1)]
    # The solver stops at an error of 1e-3 of the light.
    np.testing.assert_allclose(last, 3 * first, rtol=0, atol=1e-3 * np.abs(last).max())


def test_frames_of_baked_snow_are_no_surfaces(scene):
    """A second bake, with the frames of the first in the scene, has the same light."""
    block()
    other = block(position=(0.5, 0, 0.1))
    moving_lamp()
    baked = bake(frames=range(1, 3))
    before = flux(baked[0])
    assert bake(frames=range(1, 3), objects=[other]) == [baked[1]]
    assert bake(frames=range(1, 3)) == baked
    assert np.array_equal(flux(baked[0]), before)


@pytest.mark.parametrize("frames", [[], [1, 3, 4], [3, 2, 1]])
def test_frames_are_at_equal_distances(scene, frames):
    block()
    lamp()
    with pytest.raises(ValueError, match="frames of a bake must be one or more, upwards and at equal distances"):
        bake(frames=frames)


def test_a_world_that_follows_an_object_changes(scene):
    block()
    world((0.5, 0.5, 0.5))
    node = scene.world.node_tree.nodes.new("ShaderNodeTexCoord")
    assert not snowblue.blender._world.changes_with_time(scene.world)
    node.object = link("empty", None)
    assert snowblue.blender._world.changes_with_time(scene.world)


def test_the_kind_of_snow_is_that_of_all_frames(scene):
    thing = block()
    lamp()
    thing.snowblue.preset = "CUSTOM"
    for frame, size in ((1, 200.0), (3, 600.0)):
        thing.snowblue.grain_size_um = size
        thing.snowblue.keyframe_insert("grain_size_um", frame=frame)
    with pytest.raises(ValueError, match="the kind of the snow 'block' differs between the frames 1 and 2"):
        bake(frames=range(1, 4))


def test_frames_are_those_of_the_active_scene(scene):
    other = bpy.data.scenes.new("other")
    for thing in (block(), lamp()):
        other.collection.objects.link(thing)
    with pytest.raises(ValueError, match="in the active scene only"):
        bake(other, frames=range(1, 3))
    assert len(bake(other)) == 1


def test_another_scene_is_read_at_its_own_frame(scene):
    """A lamp and snow that move have the light of the frame of their scene, though another is active."""
    thing = block()
    for frame, x in ((1, 0.0), (5, 0.2)):
        thing.location.x = x
        thing.keyframe_insert("location", frame=frame)
    light = moving_lamp()
    scene.frame_set(5)
    with pytest.warns(UserWarning, match="of frame 5"):
        [baked] = bake()
    expected = flux(baked)
    snowblue.blender.clear()
    scene.frame_set(1)
    other = bpy.data.scenes.new("other")
    for one in (thing, light):
        other.collection.objects.link(one)
        scene.collection.objects.unlink(one)
    other.frame_set(5)
    # The originals have the values of the active scene.
    assert thing.location.x == 0
    with pytest.warns(UserWarning, match="of frame 5"):
        [baked] = bake(other)
    np.testing.assert_array_equal(flux(baked), expected)


def test_instances_of_frames_are_no_surfaces(scene):
    block()
    moving_lamp()
    [baked] = bake(frames=range(1, 3))
    empty = link("empty", None, (0, 0.3, 0))
    empty.instance_type, empty.instance_collection = "COLLECTION", baked.snowblue.frames
    job = BakeJob(scene, None, Options(**COARSE))
    with pytest.warns(UserWarning, match="'empty' makes 2 instances of 'block', whose snow is left out"):
        job.collect()
    assert job._collected[0].names == ["block"]


def test_the_operator_takes_the_range_of_the_scene(scene):
    block()
    moving_lamp()
    scene.frame_start, scene.frame_end, scene.frame_step = 2, 6, 2
    scene.snowblue_bake.use_frames = True
    assert bpy.ops.snowblue.bake() == {"FINISHED"}
    [baked] = [one for one in bpy.data.objects if one.snowblue.source]
    assert len(baked.snowblue.frames.objects) == 3
    link("other", None)
    assert bpy.ops.snowblue.clear() == {"FINISHED"} and not bpy.data.collections and not bpy.data.node_groups


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="the page has the bytes of Blender 5.0")
def test_a_frame_takes_as_many_bytes_in_a_file_as_the_page_says(scene, repository, tmp_path):
    page = (repository / "docs" / "src" / "blender.md").read_text()
    [in_file] = {int(row.split("|")[3]) for row in page.splitlines() if row.startswith("| snow ")}
    thing = block()
    moving_lamp()
    for frame, x in ((1, 0.0), (9, 0.4)):
        thing.location.x = x
        thing.keyframe_insert("location", frame=frame)
    sizes = []
    for frames in (range(1, 3), range(1, 5)):
        [baked] = bake(frames=frames, step_mm=5.0)
        path = tmp_path / f"{len(frames)}.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
        sizes.append(path.stat().st_size)
    # Blocks of data have headers.
    each = (sizes[1] - sizes[0]) / 2 / len(baked.data.vertices)
    assert each == pytest.approx(in_file, rel=0.05)
