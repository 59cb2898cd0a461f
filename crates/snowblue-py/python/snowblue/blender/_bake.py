"""Solves for the light in the snow of a scene, lamp by lamp, and makes the baked objects."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from snowblue import _native
from snowblue._arguments import VISIBLE_NM, snow_id
from snowblue._renderers import _csv, _rgb
from snowblue._scene import BakedObject, _baked, _json, _ply
from snowblue.blender._closing import extent, open_edges
from snowblue.blender._lamps import WHITE_FILE, Lamp, lamp_of
from snowblue.blender._layers import Layers, layers_of, put_layers
from snowblue.blender._material import SKY, attribute_of, fill_material
from snowblue.blender._meshes import WITH_FACES, diffuse_of, world_mesh
from snowblue.blender._settings import baked_of, is_snow, snow_of, source_of
from snowblue.blender._world import environment_of

DEFORMING = (
    *("ARMATURE", "CLOTH", "SOFT_BODY", "FLUID", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "OCEAN", "WAVE", "BUILD"),
    *("EXPLODE", "DYNAMIC_PAINT", "PARTICLE_INSTANCE", "HOOK", "LATTICE", "MESH_DEFORM", "SURFACE_DEFORM"),
)
"""Types of modifiers that change a mesh from frame to frame, or with another object."""
USUAL_SIZE_M = (0.01, 50.0)
"""Sizes of snow that need no hint at the unit of the scene."""


@dataclass
class _Scene:
    """What snowblue solves for."""

    snow: list[bpy.types.Object]
    objects: list[dict[str, Any]] = field(default_factory=list)
    """Objects of a scene, those of snow first."""
    names: list[str] = field(default_factory=list)
    """Names of the objects in Blender."""
    materials: dict[str, dict[str, Any]] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    lamps: list[Lamp] = field(default_factory=list)
    environment: dict[str, Any] | None = None
    layers: list[Layers | None] = field(default_factory=list)
    """UV maps and vertex groups of the snow."""


def bake(
    scene: bpy.types.Scene | None = None,
    objects: Iterable[bpy.types.Object] | None = None,
    *,
    step_mm: float | None = None,
    field_step_mm: float | None = None,
    max_bounces: int = 8,
    progress: Callable[[int, int], object] | None = None,
) -> list[bpy.types.Object]:
    """Solves for the light in snow and makes a baked object of each object of snow.

    The light of each lamp, and that of the World, is solved for by itself, with what comes by way of other surfaces.
    The baked object lies exactly on the original, which is hidden and kept. Its points have the net flux J outwards by
    a lamp of the energy 1 as the attributes `snow_lamp_0`, `snow_lamp_1` …, and that by the World as `snow_sky`; its
    material reads the energy and the colour of the lamps, so that these can change afterwards.

    Parameters
    ----------
    scene : bpy.types.Scene, optional
        By default that of the context.
    objects : iterable, optional
        Objects of snow, or what was baked of them; by default all snow of the scene. Other snow of the scene takes
        part in the solution.
    step_mm : float, optional
        Greatest length of an edge of the baked meshes; by default twice the cells in the snow.
    field_step_mm : float, optional
        Size of the cells in the snow at its surface; by default it follows from the size and the kind of the snow.
    max_bounces : int
        Number of surfaces over which light is followed before it enters the snow.
    progress : callable, optional
        Called with the number of solutions that are done and of all.

    Returns
    -------
    list of bpy.types.Object
        The baked objects.

    Raises
    ------
    ValueError
        If there is no snow or no lamp, an object is not a closed mesh, or a lamp is of an unknown kind.
    """
    scene = scene or bpy.context.scene
    asked = None if objects is None else list(dict.fromkeys(source_of(one) for one in objects))
    for one in asked or ():
        if not is_snow(one):
            raise ValueError(f"'{one.name}' is not snow: press 'Make Snow' first")
        if one.name not in scene.objects:
            raise ValueError(f"'{one.name}' is not in the scene '{scene.name}'")
    view_layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
    snow = [one for one in scene.objects if is_snow(one) and (one in (asked or ()) or _is_shown(one, view_layer))]
    targets = snow if asked is None else asked
    if not targets:
        raise ValueError("there is no snow: select a mesh and press 'Make Snow'")
    for one in snow:
        if one.type != "MESH":
            raise ValueError(f"'{one.name}' is a {one.type.lower()}, but snow must be a mesh")
    with _sources_shown(snow):
        made = _collected(scene, view_layer, snow)
    if not made.lamps and made.environment is None:
        raise ValueError("the scene has no lamp: add one, or give the World a colour")
    document: dict[str, Any] = {
        "camera": {"position": [0, -1, 0], "look_at": [0, 0, 0]},
        "integrator": {"type": "diffusion", "max_bounces": max_bounces},
        "material": made.materials,
        "object": made.objects,
    }
    if field_step_mm is not None:
        document["light_field"] = {"step_mm": field_step_mm}
    baked, fluxes = _solved(document, made, step_mm, progress)
    names = [attribute_of(number) for number in range(len(made.lamps))] + ([SKY] if made.environment else [])
    unit_m = scene.unit_settings.scale_length
    results = []
    for number, source in enumerate(snow):
        if source in targets:
            attributes = {name: flux[number] for name, flux in zip(names, fluxes)}
            results.append(_put(source, baked[number], attributes, unit_m))
            if made.layers[number] is not None:
                put_layers(made.layers[number], results[-1])
            results[-1]["snow_id"] = snow_id(snow_of(source))
            fill_material(
                results[-1].data.materials[0], made.lamps, SKY in names, baked[number].escape_polynomial.tolist()
            )
    return results


def clear(scene: bpy.types.Scene | None = None, objects: Iterable[bpy.types.Object] | None = None) -> int:
    """Removes the baked objects of a scene, or of some objects, and shows the originals.

    Returns the number of baked objects removed.
    """
    scene = scene or bpy.context.scene
    sources = [source_of(one) for one in (scene.objects if objects is None else objects)]
    count = 0
    for source in dict.fromkeys(sources):
        baked = baked_of(source)
        if baked is None:
            continue
        _remove_mesh(baked.data, lambda: bpy.data.objects.remove(baked))
        settings = source.snowblue
        source.hide_viewport, source.hide_render = settings.was_hidden_in_viewport, settings.was_hidden_in_render
        count += 1
    return count


def _is_shown(source: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> bool:
    """Whether pictures show some snow, as itself or baked."""
    shown = baked_of(source) or source
    return not shown.hide_render and shown.visible_get(view_layer=view_layer)


@contextmanager
def _sources_shown(snow: list[bpy.types.Object]) -> Iterator[None]:
    """Makes Blender evaluate snow that a baked object stands for."""
    hidden = {one: one.hide_viewport for one in snow}
    try:
        for one in snow:
            one.hide_viewport = False
        yield
    finally:
        for one, value in hidden.items():
            one.hide_viewport = value


def _collected(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, snow: list[bpy.types.Object]) -> _Scene:
    """The objects, lamps and World of a scene."""
    made = _Scene(snow)
    unit_m = scene.unit_settings.scale_length
    with bpy.context.temp_override(scene=scene, view_layer=view_layer):
        depsgraph = bpy.context.evaluated_depsgraph_get()
    depsgraph.update()
    points = []
    for source in snow:
        # Blender does not evaluate the modifiers of what is hidden.
        if not source.visible_get(view_layer=view_layer):
            raise ValueError(f"'{source.name}' is hidden in the viewport, or its collection is: show it to bake it")
        vertices, triangles, _ = world_mesh(source.evaluated_get(depsgraph), source.matrix_world, unit_m)
        if not len(triangles):
            raise ValueError(f"'{source.name}' has no faces, but snow must be a closed mesh")
        count = open_edges(vertices, triangles)
        if count:
            raise ValueError(
                f"'{source.name}' has {count} open edges, but snow must be closed: press 'Make Snow' and choose Fill "
                "Holes or Voxel Remesh"
            )
        _check_size(source, vertices)
        _check_still(source, scene)
        points.append(vertices)
        made.layers.append(layers_of(source.evaluated_get(depsgraph)))
        # Equal snow is one material, as in a body.
        material = {"type": "snow", **snow_of(source)}
        name = json.dumps(material)
        made.materials[name] = material
        body = source.snowblue.body.strip()
        _add(made, source.name, vertices, triangles, name, {"body": body} if body else {})
    snow_m = np.concatenate(points)
    for instance in depsgraph.object_instances:
        thing = instance.object.original
        if is_snow(thing) or thing.snowblue.source:
            if instance.is_instance:
                warnings.warn(f"an instance of '{thing.name}' is left out: make it real to have snow", stacklevel=3)
            continue
        if thing.hide_render:
            continue
        if thing.type == "LIGHT":
            _check_still(thing, scene)
            lamp = lamp_of(thing, instance.matrix_world.copy(), unit_m, snow_m)
            made.lamps += [lamp] if lamp else []
        elif thing.type in WITH_FACES and instance.show_self:
            _add_surfaces(made, thing, instance.object, instance.matrix_world.copy(), unit_m)
    for thing in view_layer.objects:
        is_hidden = not thing.hide_render and not thing.visible_get(view_layer=view_layer)
        if is_hidden and (thing.type in WITH_FACES or thing.type == "LIGHT") and thing not in snow:
            warnings.warn(f"'{thing.name}' is hidden in the viewport: the light in the snow lacks it", stacklevel=3)
    made.files[WHITE_FILE] = _csv(np.ones(len(VISIBLE_NM)))
    made.environment = environment_of(scene, made.files)
    return made


def _add_surfaces(
    made: _Scene, thing: bpy.types.Object, evaluated: bpy.types.Object, to_world: Matrix, unit_m: float
) -> None:
    """Adds a surface that is not snow, as one object for each of its materials."""
    vertices, triangles, slots = world_mesh(evaluated, to_world, unit_m)
    for slot in np.unique(slots):
        material = f"{thing.name} {slot}"
        made.materials[material] = diffuse_of(thing, int(slot))
        _add(made, thing.name, vertices, triangles[slots == slot], material, {})


def _add(
    made: _Scene, name: str, vertices: np.ndarray, triangles: np.ndarray, material: str, more: dict[str, Any]
) -> None:
    # Names of files differ, even where linked objects have one name.
    file = f"{len(made.objects)}.ply"
    made.names.append(name)
    used, corners = np.unique(triangles, return_inverse=True)
    made.files[file] = _ply(vertices[used].astype("<f4"), corners.reshape(-1, 3))
    made.objects.append({"mesh": file, "up": "z", "material": material, **more})


def _check_size(source: bpy.types.Object, vertices: np.ndarray) -> None:
    size_m = extent(vertices)
    if not USUAL_SIZE_M[0] <= size_m <= USUAL_SIZE_M[1]:
        warnings.warn(
            f"'{source.name}' is {size_m:.3g} m large: if that is not meant, change the Unit Scale of the scene or the "
            "size of the object",
            stacklevel=4,
        )


def _check_still(thing: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """Warns of what moves or deforms in the animation."""
    chain = [thing]
    while chain[-1].parent is not None:
        chain.append(chain[-1].parent)
    keys = thing.data.shape_keys if thing.type == "MESH" else None
    reasons = [f"'{one.name}' is animated" for one in chain if _is_animated(one)]
    reasons += [
        f"the constraint '{constraint.name}' moves '{one.name}'"
        for one in chain
        for constraint in one.constraints
        if not constraint.mute
    ]
    # The mesh is that of the viewport.
    shown = [one for one in thing.modifiers if one.show_viewport]
    reasons += [f"the modifier '{one.name}' deforms it" for one in shown if one.type in DEFORMING]
    reasons += ["its shape keys are animated"] if keys is not None and _is_animated(keys) else []
    if reasons:
        warnings.warn(
            f"the light in the snow is that of frame {scene.frame_current}, and '{thing.name}' may change: "
            f"{reasons[0]}; bake again for other frames",
            stacklevel=4,
        )


def _is_animated(data: bpy.types.ID) -> bool:
    animation = data.animation_data
    return animation is not None and bool(animation.action or animation.drivers or animation.nla_tracks)


def _solved(
    document: dict[str, Any],
    made: _Scene,
    step_mm: float | None,
    progress: Callable[[int, int], object] | None,
) -> tuple[list[BakedObject], list[list[np.ndarray]]]:
    """The baked objects of snow, and the flux (n, 3) on each by each lamp and last by the World."""
    lights = [{"light": [lamp.description]} for lamp in made.lamps]
    lights += [{"light": [], "environment": made.environment}] if made.environment else []
    first: list[BakedObject] = []
    fluxes = []
    for number, light in enumerate(lights):
        # The spectrum of an image is made of its colours, so that its flux is a colour.
        is_image = "image" in light.get("environment", {})
        objects = _bake_one(document | light, made, step_mm, not is_image)
        first = first or objects
        for name, one, other in zip(made.names, first, objects):
            if not np.array_equal(one.positions, other.positions):
                raise ValueError(f"the meshes of '{name}' differ between lamps: give a Step")
        fluxes.append([one.flux[0] if is_image else _rgb(one.flux[0]) for one in objects])
        if progress is not None:
            progress(number + 1, len(lights))
    return first, fluxes


def _bake_one(document: dict[str, Any], made: _Scene, step_mm: float | None, spectrum: bool) -> list[BakedObject]:
    content = {"spectrum": spectrum, "is_total": True, "reflection": False}
    try:
        scene = _native.Scene.from_json(_json(document), made.files, ".")
        return [_baked(one, []) for one in scene.bake(step_mm, content, None, None)[1:]]
    except ValueError as error:
        reason = str(error)
        for number, name in enumerate(made.names):
            reason = reason.replace(f"object[{number}]", f"'{name}'")
        raise ValueError(reason) from None


def _put(
    source: bpy.types.Object, baked: BakedObject, attributes: dict[str, np.ndarray], unit_m: float
) -> bpy.types.Object:
    """Makes the baked object of some snow, or gives it a new mesh, and hides the original."""
    name = f"{source.name} baked"
    to_local = source.matrix_world.inverted()
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
    for key, values in attributes.items():
        attribute = mesh.attributes.new(key, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", np.ascontiguousarray(values, dtype=np.float32).ravel())
    mesh.materials.append(bpy.data.materials.new(f"Snow of {source.name}"))
    thing = baked_of(source)
    if thing is None:
        thing = bpy.data.objects.new(name, mesh)
        for collection in source.users_collection:
            collection.objects.link(thing)
        thing.parent = source
        thing.snowblue.source = source
        settings = source.snowblue
        settings.was_hidden_in_viewport, settings.was_hidden_in_render = source.hide_viewport, source.hide_render
    else:
        old = thing.data
        thing.data = mesh
        _remove_mesh(old, lambda: None)
    source.hide_viewport = source.hide_render = True
    return thing


def _local(baked: BakedObject, to_local: Matrix, unit_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions in the space of the original, and normals there."""
    matrix = np.array(to_local)
    positions = baked.positions / unit_m @ matrix[:3, :3].T + matrix[:3, 3]
    # Normals transform by the inverse of the transposed matrix.
    normals = baked.normals @ np.linalg.inv(matrix[:3, :3])
    return positions, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _remove_mesh(mesh: bpy.types.Mesh, before: Callable[[], object]) -> None:
    """Removes a baked mesh and its materials, after its object."""
    materials = [material for material in mesh.materials if material]
    before()
    bpy.data.meshes.remove(mesh)
    for material in materials:
        if material.users == 0:
            bpy.data.materials.remove(material)
