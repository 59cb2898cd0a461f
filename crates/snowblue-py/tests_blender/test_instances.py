"""Instances: those of other things light and shade snow, those of snow are named."""

import warnings

import bpy
import numpy as np
import pytest
from test_blender import bake, block, lamp, link
from test_jobs import flux

import snowblue.blender


def scattered(thing, what=None):
    """Adds a modifier that makes an instance at each vertex: of an object, or of a cube of nodes."""
    group = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    add, link_ = group.nodes.new, group.links.new
    start, end = add("NodeGroupInput"), add("NodeGroupOutput")
    points, join = add("GeometryNodeInstanceOnPoints"), add("GeometryNodeJoinGeometry")
    if what is None:
        made = add("GeometryNodeMeshCube")
        made.inputs["Size"].default_value = (0.2, 0.2, 0.2)
        source = made.outputs["Mesh"]
    else:
        made = add("GeometryNodeObjectInfo")
        made.inputs["Object"].default_value = what
        source = made.outputs["Geometry"]
    link_(start.outputs[0], points.inputs["Points"])
    link_(source, points.inputs["Instance"])
    link_(points.outputs[0], join.inputs[0])
    link_(start.outputs[0], join.inputs[0])
    link_(join.outputs[0], end.inputs[0])
    thing.modifiers.new("scatter", "NODES").node_group = group
    return group


def in_collection(thing):
    """Takes an object out of the scene, into a collection of which an empty makes an instance."""
    collection = bpy.data.collections.new("things")
    collection.objects.link(thing)
    for one in list(thing.users_collection):
        if one != collection:
            one.objects.unlink(thing)
    empty = link("empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    return empty


def texts(caught):
    return [str(one.message) for one in caught if one.category is UserWarning]


def test_instances_that_snow_makes_are_named_once(scene):
    thing = block()
    group = scattered(thing)
    lamp()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        [baked] = bake()
    [text] = texts(caught)
    assert text.startswith("'block' makes 8 instances, which the bake leaves out and hides: add a Realize Instances")
    without = len(baked.data.vertices)
    # As the text says.
    realize = group.nodes.new("GeometryNodeRealizeInstances")
    end = next(node for node in group.nodes if node.type == "GROUP_OUTPUT")
    group.links.new(end.inputs[0].links[0].from_socket, realize.inputs[0])
    group.links.new(realize.outputs[0], end.inputs[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bake()
    assert len(baked.data.vertices) > without


def test_snow_in_an_instance_of_a_collection_is_named(scene):
    thing = block()
    lamp()
    empty = in_collection(thing)
    with pytest.raises(ValueError, match="there is no snow but in instances: .* Make Instances Real"):
        bake()
    other = block(position=(0.5, 0, 0.1))
    other.name = "other"
    with pytest.warns(UserWarning, match="'empty' makes an instance of 'block', whose snow is left out: use Object"):
        [baked] = bake()
    assert baked.snowblue.source == other
    # As the text says.
    snowblue.blender.clear()
    bpy.ops.object.select_all(action="DESELECT")
    empty.select_set(True)
    bpy.ops.object.duplicates_make_real()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(bake()) == 2


def test_instances_of_other_things_count(scene):
    """A wall in an instance shades snow as the wall itself does."""
    block()
    lamp()
    bpy.ops.mesh.primitive_cube_add(size=0.2, location=(0, 0.3, 0.1))
    wall = bpy.context.object
    [baked] = bake()
    shaded = flux(baked)
    in_collection(wall)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bake()
    assert np.array_equal(flux(baked), shaded)
    bpy.data.objects.remove(bpy.data.objects["empty"])
    bake()
    assert not np.allclose(flux(baked), shaded)
