"""What snowblue solves for, of a scene of Blender: its snow, lamps, World and other surfaces at one frame.

Nothing that stays holds a reference to an object of Blender: those end with an undo. Objects have a `session_uid`.
"""

from __future__ import annotations

import json
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from snowblue._arguments import VISIBLE_NM, snow_id
from snowblue._renderers import _csv
from snowblue._scene import _ply
from snowblue.blender._closing import extent, open_edges
from snowblue.blender._lamps import WHITE_FILE, Lamp, SnowSurface, lamp_of
from snowblue.blender._layers import Layers, layers_of
from snowblue.blender._meshes import WITH_FACES, material_of, placed, world_mesh
from snowblue.blender._settings import baked_of, is_snow, object_of, painted_of, scene_of, snow_of, source_of
from snowblue.blender._world import Skylight, changes_with_time, skylight_of

DEFORMING = (
    *("ARMATURE", "CLOTH", "SOFT_BODY", "FLUID", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "OCEAN", "WAVE", "BUILD"),
    *("EXPLODE", "DYNAMIC_PAINT", "PARTICLE_INSTANCE", "HOOK", "LATTICE", "MESH_DEFORM", "SURFACE_DEFORM"),
)
"""Types of modifiers that change a mesh from frame to frame, or with another object."""
PAINT = "paint"
"""The attribute of a mesh with the weights of painted snow."""
USUAL_SIZE_M = (0.01, 50.0)
"""Sizes of snow that need no hint at the unit of the scene."""


@dataclass(frozen=True)
class Request:
    """What is to be baked."""

    scene: int
    view_layer: str
    snow: list[int]
    """All snow that takes part."""
    targets: list[int]
    """Snow that gets a baked object."""


@dataclass(frozen=True)
class Snow:
    """An object of snow at one frame."""

    uid: int
    to_world: Matrix
    shape: tuple[np.ndarray, np.ndarray]
    """Vertices and triangles in the space of the object, with its modifiers."""
    layers: Layers | None
    """UV maps and vertex groups."""
    identifier: str


@dataclass
class Collected:
    """What snowblue solves for at one frame."""

    frame: int
    unit_m: float
    snow: list[Snow] = field(default_factory=list)
    objects: list[dict[str, Any]] = field(default_factory=list)
    """Objects of a scene, those of snow first."""
    names: list[str] = field(default_factory=list)
    """Names of the objects in Blender."""
    materials: dict[str, dict[str, Any]] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    lamps: list[Lamp] = field(default_factory=list)
    skylight: list[Skylight] = field(default_factory=list)
    """The light of the World, in parts."""

    @property
    def suns(self) -> dict[int, Vector]:
        """The directions of the sun discs of the World by their identifiers -1, -2 and so on."""
        directions = [part.to_sun for part in self.skylight if part.to_sun is not None]
        return {-1 - number: direction for number, direction in enumerate(directions)}


def request_of(scene: bpy.types.Scene, objects: Iterable[bpy.types.Object] | None) -> Request:
    """All snow of a scene, of which some objects, or what was baked of them, or by default all are to be baked.

    Raises
    ------
    ValueError
        If there is no snow, or one of the objects is no snow of the scene.
    """
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
        if asked is None and any(is_snow(one) and one.name not in scene.objects for one in bpy.data.objects):
            raise ValueError("there is no snow but in instances: use Object > Apply > Make Instances Real")
        raise ValueError("there is no snow: select a mesh and press 'Make Snow'")
    for one in snow:
        if one.type != "MESH":
            raise ValueError(f"'{one.name}' is a {one.type.lower()}, but snow must be a mesh")
    uids = [[one.session_uid for one in group] for group in (snow, targets)]
    return Request(scene.session_uid, view_layer.name, *uids)


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


@contextmanager
def _at_frame(scene: bpy.types.Scene, frame: int | None) -> Iterator[None]:
    """A scene at a frame, and then at its present one again. None leaves it as it is, with what is not keyed."""
    before = scene.frame_current, scene.frame_subframe
    if frame is not None:
        scene.frame_set(frame)
    try:
        yield
    finally:
        if frame is not None:
            scene.frame_set(before[0], subframe=before[1])


@contextmanager
def _evaluated(
    request: Request, frame: int | None
) -> Iterator[tuple[bpy.types.Scene, bpy.types.ViewLayer, bpy.types.Depsgraph, list[bpy.types.Object]]]:
    """The scene, its view layer, the evaluated scene and the snow of a request at a frame."""
    scene = scene_of(request.scene)
    if scene is None:
        raise ValueError("the scene was removed while it was baked")
    view_layer = scene.view_layers.get(request.view_layer, scene.view_layers[0])
    snow = [one for one in map(object_of, request.snow) if one is not None and one.name in scene.objects]
    with _sources_shown(snow), _at_frame(scene, frame):
        with bpy.context.temp_override(scene=scene, view_layer=view_layer):
            depsgraph = bpy.context.evaluated_depsgraph_get()
        depsgraph.update()
        yield scene, view_layer, depsgraph, snow


def collect(request: Request, frame: int | None, earlier: Collected | None = None) -> Collected:
    """The objects, lamps and World of a scene at a frame of several, or as it is.

    `earlier` is another frame, of which the light of a World is taken that does not change with time.

    Raises
    ------
    ValueError
        If there is no light, an object is not a closed mesh, a lamp is of an unknown kind, the scene of several frames
        is not active, or the kind of the snow changes.
    """
    if frame is not None and bpy.context.scene.session_uid != request.scene:
        # Animated values reach the originals in the active scene alone.
        raise ValueError("several frames can be baked in the active scene only: make the scene active")
    with _evaluated(request, frame) as (scene, view_layer, depsgraph, snow):
        made = Collected(scene.frame_current, scene.unit_settings.scale_length)
        if len(snow) != len(request.snow):
            raise ValueError("an object of snow was removed while it was baked")
        # One of several frames needs no warning of what moves.
        warned = scene if frame is None else None
        surface = SnowSurface([_add_snow(made, one, view_layer, depsgraph, warned) for one in snow])
        _check_kinds(made, earlier, request.targets)
        _add_rest(made, depsgraph, surface, warned)
        for thing in view_layer.objects:
            is_hidden = not thing.hide_render and not thing.visible_get(view_layer=view_layer)
            if is_hidden and (thing.type in WITH_FACES or thing.type == "LIGHT") and thing not in snow:
                warnings.warn(f"'{thing.name}' is hidden in the viewport: the light in the snow lacks it", stacklevel=3)
        made.files[WHITE_FILE] = _csv(np.ones(len(VISIBLE_NM)))
        is_still = earlier is not None and not changes_with_time(scene.world)
        made.skylight = earlier.skylight if is_still else skylight_of(scene)
    if not made.lamps and not made.skylight:
        raise ValueError("the scene has no lamp: add one, or give the World a colour")
    return made


def unchanged_snow(request: Request, earlier: Collected) -> list[int]:
    """The snow to be baked that is still there as it was collected. Warns of the rest.

    Raises
    ------
    ValueError
        If there is none.
    """
    scene = scene_of(request.scene)
    is_there = scene is not None and scene.frame_current == earlier.frame
    with _evaluated(request, None if is_there else earlier.frame) as (_, _, depsgraph, snow):
        there = {one.session_uid: one for one in snow}
        found = {uid: world_mesh(one.evaluated_get(depsgraph), Matrix(), 1.0)[:2] for uid, one in there.items()}
    unchanged = []
    for name, one in zip(earlier.names, earlier.snow):
        thing = there.get(one.uid)
        if one.uid not in request.targets:
            continue
        if thing is None:
            done = "was removed"
        elif not is_snow(thing):
            done = "was marked as no snow"
        elif thing.mode != "OBJECT":
            done = "left Object Mode"
        elif not all(map(np.array_equal, found[one.uid], one.shape)):
            done = "was changed"
        else:
            unchanged.append(one.uid)
            continue
        warnings.warn(f"'{name}' {done} while it was baked: it has no light of this bake", stacklevel=3)
    if not unchanged:
        raise ValueError("the snow was changed or removed while it was baked: bake again")
    return unchanged


def _add_snow(
    made: Collected,
    source: bpy.types.Object,
    view_layer: bpy.types.ViewLayer,
    depsgraph: bpy.types.Depsgraph,
    warned: bpy.types.Scene | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Adds an object of snow, and gives its vertices in m and its triangles."""
    # Blender does not evaluate the modifiers of what is hidden.
    if not source.visible_get(view_layer=view_layer):
        raise ValueError(f"'{source.name}' is hidden in the viewport, or its collection is: show it to bake it")
    shown = source.evaluated_get(depsgraph)
    shape = world_mesh(shown, Matrix(), 1.0)[:2]
    # The original follows the active scene alone.
    to_world = shown.matrix_world.copy()
    vertices, triangles = placed(shape[0], to_world, made.unit_m), shape[1]
    if not len(triangles):
        raise ValueError(f"'{source.name}' has no faces, but snow must be a closed mesh")
    count = open_edges(vertices, triangles)
    if count:
        raise ValueError(
            f"'{source.name}' has {count} open edges, but snow must be closed: press 'Make Snow' and choose Fill "
            "Holes or Voxel Remesh"
        )
    _check_size(source, vertices)
    if warned is not None:
        _check_still(source, warned)
    layers, kinds = layers_of(shown), [snow_of(shown)]
    painted = painted_of(shown)
    material, attributes = {"type": "snow", **kinds[0]}, {}
    if painted is not None:
        group = shown.snowblue.painted
        if layers is None or group not in layers.groups:
            raise ValueError(f"'{source.name}' has no vertex group '{group}' of painted snow: choose another, or none")
        kinds.append(painted)
        material = {"type": "snow", "mask": {"attribute": PAINT}, "between": kinds}
        attributes[PAINT] = layers.groups[group]
    identifier = "+".join(map(snow_id, kinds))
    made.snow.append(Snow(source.session_uid, to_world, shape, layers, identifier))
    # Equal snow is one material, as in a body.
    name = json.dumps(material)
    made.materials[name] = material
    body = source.snowblue.body.strip()
    _add(made, source.name, vertices, triangles, name, {"body": body} if body else {}, attributes)
    return vertices, triangles


def _add_rest(
    made: Collected, depsgraph: bpy.types.Depsgraph, surface: SnowSurface, warned: bpy.types.Scene | None
) -> None:
    """Adds lamps and surfaces that are not snow, and warns of instances that are left out."""
    left_out: Counter[tuple[str, str]] = Counter()
    baked = [one for one in bpy.data.objects if one.snowblue.frames is not None]
    frames = {one: thing.snowblue.source for thing in baked for one in thing.snowblue.frames.objects}
    for instance in depsgraph.object_instances:
        thing = instance.object.original
        source = frames.get(thing) or source_of(thing)
        maker = instance.parent.original if instance.is_instance else None
        if maker is not None and maker.snowblue.source:
            # A frame of a baked object.
            continue
        if is_snow(thing) or source != thing:
            if maker is not None:
                left_out[maker.name, source.name] += 1
            continue
        if instance.object.hide_render:
            continue
        if thing.type == "LIGHT":
            if warned is not None:
                _check_still(thing, warned)
            lamp = lamp_of(instance.object, instance.matrix_world.copy(), made.unit_m, surface)
            made.lamps += [lamp] if lamp else []
        elif thing.type in WITH_FACES and instance.show_self:
            _add_surfaces(made, thing, instance.object, instance.matrix_world.copy())
    for (maker_name, name), count in left_out.items():
        instances = "an instance" if count == 1 else f"{count} instances"
        if maker_name == name:
            text = (
                f"'{name}' makes {instances}, which the bake leaves out and hides: add a Realize Instances node for "
                "those of snow, and move others to an object that is not snow"
            )
        else:
            text = (
                f"'{maker_name}' makes {instances} of '{name}', whose snow is left out: use Object > Apply > Make "
                "Instances Real to have it"
            )
        warnings.warn(text, stacklevel=3)


def _add_surfaces(
    made: Collected, thing: bpy.types.Object, shown: bpy.types.Object, to_world: Matrix
) -> None:
    """Adds a surface that is not snow, as one object for each of its materials."""
    vertices, triangles, slots = world_mesh(shown, to_world, made.unit_m)
    for slot in np.unique(slots):
        material = f"{thing.name} {slot}"
        made.materials[material] = material_of(thing, int(slot))
        _add(made, thing.name, vertices, triangles[slots == slot], material, {})


def _add(
    made: Collected,
    name: str,
    vertices: np.ndarray,
    triangles: np.ndarray,
    material: str,
    more: dict[str, Any],
    attributes: dict[str, np.ndarray] | None = None,
) -> None:
    # Names of files differ, even where linked objects have one name.
    file = f"{len(made.objects)}.ply"
    made.names.append(name)
    used, corners = np.unique(triangles, return_inverse=True)
    values = {key: numbers[used] for key, numbers in (attributes or {}).items()}
    made.files[file] = _ply(vertices[used].astype("<f4"), corners.reshape(-1, 3), values)
    made.objects.append({"mesh": file, "up": "z", "material": material, **more})


def _check_kinds(made: Collected, earlier: Collected | None, targets: list[int]) -> None:
    """Refuses snow whose kind changes: a baked object has one material."""
    for number, (one, before) in enumerate(zip(made.snow, earlier.snow if earlier is not None else ())):
        if one.uid in targets and one.identifier != before.identifier:
            raise ValueError(
                f"the kind of the snow '{made.names[number]}' differs between the frames {earlier.frame} and "
                f"{made.frame}: bake each frame alone, or remove the animation of its settings"
            )


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
