"""Baked objects: a mesh with the light as attributes, exactly on the original, for one frame or for each of several.

With several frames, each has a mesh of its own. A modifier of geometry nodes shows that of the frame, so that files
play and render without the add-on.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix, Vector

from snowblue._scene import BakedObject
from snowblue.blender._collect import Collected, Snow
from snowblue.blender._lamps import is_driven
from snowblue.blender._layers import put_layers
from snowblue.blender._material import (
    IRRADIANCE,
    LAMP,
    PLACE,
    SKY,
    SUN,
    LightNodes,
    fill_material,
    remove_material,
)
from snowblue.blender._nodes import Tree
from snowblue.blender._settings import baked_of, object_of
from snowblue.blender._solve import WORLD, Solution

MODIFIER = "Snow Frames"
"""The name of the modifier."""


def put(frames: list[Collected], solutions: list[Solution], targets: Sequence[int]) -> list[bpy.types.Object]:
    """Makes the baked objects of some snow, or gives them new meshes, and hides the originals."""
    names, lights = {}, []
    lamps = {one.uid: one for made in frames for one in made.lamps}
    for lamp in lamps.values():
        thing = object_of(lamp.uid)
        if thing is None or not is_driven(lamp, thing):
            done = "removed" if thing is None else "changed in its type, Normalize or nodes"
            warnings.warn(f"lamp '{lamp.name}' was {done}: its light in the snow is left out", stacklevel=3)
            continue
        names[lamp.uid] = f"{LAMP}{len(lights)}"
        lights.append(LightNodes(names[lamp.uid], lamp.name, thing, thing.data.type == "SUN"))
    if any(made.skylight for made in frames):
        names[WORLD] = SKY
        lights.append(LightNodes(SKY, "World"))
        for number, key in enumerate(max((made.suns for made in frames), key=len)):
            names[key] = f"{SUN}{number}"
            lights.append(LightNodes(names[key], "sun of the World", is_distant=True))
    if not lights:
        raise ValueError("the lamps were removed or changed while the snow was baked: bake again with one")
    results = []
    for number, first in enumerate(frames[0].snow):
        source = object_of(first.uid)
        if first.uid not in targets or source is None:
            continue
        material = bpy.data.materials.new(f"Snow of {source.name}")
        escape = solutions[0].objects[number].escape_polynomial.tolist()
        fill_material(material, lights, escape, solutions[0].reflections[number])
        things: list[bpy.types.Object] = []
        shape = None
        for made, solution in zip(frames, solutions):
            attributes = {names[key]: flux[number] for key, flux in solution.fluxes.items() if key in names}
            for key, irradiance in solution.irradiances.items():
                if key in names:
                    attributes[names[key] + IRRADIANCE] = irradiance[number]
            snow, objects = made.snow[number], solution.objects
            # Copies share what does not differ.
            is_same = shape is not None and _is_same(shape, (snow, objects[number]))
            shape = snow, objects[number]
            if is_same:
                mesh = things[-1].data.copy()
            else:
                mesh = _mesh(f"{source.name} baked", snow, objects[number], made.unit_m)
                mesh.materials.append(material)
            _put_attributes(mesh, attributes)
            # Geometry nodes sort the objects of a collection by their names.
            things.append(bpy.data.objects.new(f"{len(things):05d} {source.name} baked", mesh))
            _put_places(things[-1], {names[key]: place for key, place in _places(made).items() if key in names})
            if snow.layers is not None and not is_same:
                put_layers(snow.layers, things[-1])
        results.append(_replaced(source, things, [made.frame for made in frames]))
        results[-1]["snow_id"] = first.identifier
    return results


def remove_baked(thing: bpy.types.Object) -> None:
    """Removes a baked object with its meshes and materials, and shows the original."""
    source = thing.snowblue.source
    _remove_frames(thing)
    mesh = thing.data
    bpy.data.objects.remove(thing)
    _remove_meshes([mesh])
    settings = source.snowblue
    source.hide_viewport, source.hide_render = settings.was_hidden_in_viewport, settings.was_hidden_in_render


def _mesh(name: str, snow: Snow, baked: BakedObject, unit_m: float) -> bpy.types.Mesh:
    to_local = snow.to_world.inverted()
    positions, normals = _local(baked, to_local, unit_m)
    # A mirrored object turns its triangles inside out.
    triangles = baked.triangles if to_local.determinant() > 0 else baked.triangles[:, ::-1]
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.astype(np.float32).ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(triangles), dtype=bool))
    mesh.normals_split_custom_set_from_vertices(normals.tolist())
    return mesh


def _is_same(earlier: tuple[Snow, BakedObject], later: tuple[Snow, BakedObject]) -> bool:
    """Whether two frames have one mesh, but for its light."""
    (snow, baked), (other_snow, other) = earlier, later
    is_same = snow.to_world == other_snow.to_world and all(map(np.array_equal, snow.shape, other_snow.shape))
    return is_same and all(
        np.array_equal(getattr(baked, name), getattr(other, name)) for name in ("positions", "normals", "triangles")
    )


def _put_attributes(mesh: bpy.types.Mesh, attributes: dict[str, np.ndarray]) -> None:
    for name in [one.name for one in mesh.attributes if one.name.startswith((SKY, SUN, LAMP))]:
        if name not in attributes:
            mesh.attributes.remove(mesh.attributes[name])
    for name, values in attributes.items():
        kind = "FLOAT2" if values.shape[1] == 2 else "FLOAT_VECTOR"
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, "POINT")
        attribute.data.foreach_set("vector", np.ascontiguousarray(values, dtype=np.float32).ravel())


def _places(made: Collected) -> dict[int, Vector]:
    """Where each lamp and sun disc is."""
    return {lamp.uid: lamp.place for lamp in made.lamps} | made.suns


def _place_keys(thing: bpy.types.Object) -> list[str]:
    return [one for one in thing.keys() if one.startswith((SUN, LAMP)) and one.endswith(PLACE)]


def _put_places(thing: bpy.types.Object, places: dict[str, Vector]) -> None:
    for key in _place_keys(thing):
        del thing[key]
    for name, place in places.items():
        thing[name + PLACE] = list(place)


def _replaced(source: bpy.types.Object, things: list[bpy.types.Object], frames: list[int]) -> bpy.types.Object:
    """The baked object of some snow, with the meshes of objects that stand for frames."""
    mesh = things[0].data
    thing = baked_of(source)
    if thing is None:
        thing = bpy.data.objects.new(f"{source.name} baked", mesh)
        for collection in source.users_collection:
            collection.objects.link(thing)
        thing.parent = source
        thing.snowblue.source = source
        settings = source.snowblue
        settings.was_hidden_in_viewport, settings.was_hidden_in_render = source.hide_viewport, source.hide_render
    else:
        _remove_frames(thing)
        old = thing.data
        thing.data = mesh
        _remove_meshes([old])
    _put_places(thing, {key.removesuffix(PLACE): Vector(things[0][key]) for key in _place_keys(things[0])})
    if len(frames) == 1:
        bpy.data.objects.remove(things[0])
    else:
        _put_frames(thing, things, frames)
    source.hide_viewport = source.hide_render = True
    return thing


def _put_frames(thing: bpy.types.Object, things: list[bpy.types.Object], frames: list[int]) -> None:
    """Makes a baked object show one of some objects, by the frame."""
    collection = bpy.data.collections.new(f"{thing.name} frames")
    for one in things:
        collection.objects.link(one)
    thing.snowblue.frames = collection
    group = bpy.data.node_groups.new(f"{MODIFIER} of {thing.name}", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    tree = Tree(group)
    time, index = tree.add("GeometryNodeInputSceneTime", 0, 0), tree.add("GeometryNodeInputIndex", 4, 1)
    passed = tree.math("SUBTRACT", 1, 0, time.outputs["Frame"], frames[0])
    number = tree.math("DIVIDE", 2, 0, passed, frames[1] - frames[0])
    number = tree.math("FLOOR", 3, 0, number)
    # Before the first frame and after the last, those are shown.
    number = tree.math("MAXIMUM", 4, 0, number, 0.0)
    number = tree.math("MINIMUM", 5, 0, number, len(frames) - 1.0)
    is_shown = tree.math("COMPARE", 6, 0, number, index.outputs[0], 0.5)
    every = tree.add("GeometryNodeCollectionInfo", 6, 1)
    every.inputs["Collection"].default_value = collection
    every.inputs["Separate Children"].default_value = every.inputs["Reset Children"].default_value = True
    separate = tree.add("GeometryNodeSeparateGeometry", 7, 0, domain="INSTANCE")
    tree.link(every.outputs[0], separate.inputs["Geometry"])
    tree.link(is_shown, separate.inputs["Selection"])
    output = tree.add("NodeGroupOutput", 8, 0)
    tree.link(separate.outputs["Selection"], output.inputs[0])
    modifier = thing.modifiers.new(MODIFIER, "NODES")
    modifier.node_group = group
    thing.modifiers.move(len(thing.modifiers) - 1, 0)


def _remove_frames(thing: bpy.types.Object) -> None:
    """Makes a baked object show its own mesh."""
    collection = thing.snowblue.frames
    if collection is None:
        return
    for modifier in [one for one in thing.modifiers if one.type == "NODES" and one.name.startswith(MODIFIER)]:
        group = modifier.node_group
        thing.modifiers.remove(modifier)
        if group is not None and group.users == 0:
            bpy.data.node_groups.remove(group)
    meshes = [one.data for one in collection.objects if one.data != thing.data]
    for one in list(collection.objects):
        bpy.data.objects.remove(one)
    bpy.data.collections.remove(collection)
    _remove_meshes(meshes)


def _local(baked: BakedObject, to_local: Matrix, unit_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the space of the original, and normals there."""
    matrix = np.array(to_local)
    positions = baked.positions / unit_m @ matrix[:3, :3].T + matrix[:3, 3]
    # Normals transform by the inverse of the transposed matrix.
    normals = baked.normals @ np.linalg.inv(matrix[:3, :3])
    return positions, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _remove_meshes(meshes: list[bpy.types.Mesh]) -> None:
    """Removes baked meshes and their materials, after their objects."""
    materials = {material for mesh in meshes for material in mesh.materials if material}
    for mesh in meshes:
        bpy.data.meshes.remove(mesh)
    for material in materials:
        remove_material(material)
