"""What the user says about an object of snow, stored with the object."""

from __future__ import annotations

from typing import Any

import bpy

from snowblue import _native

PRESETS = {
    "FRESH": ("Fresh powder", "New snow, fine and light", 93.0, 80.0),
    "SETTLED": ("Settled snow", "Rounded grains, some days old", 350.0, 250.0),
    "OLD": ("Old settled snow", "Rounded grains, some weeks old", 400.0, 300.0),
    "WIND": ("Wind-packed snow", "Dense snow of broken, rounded grains", 440.0, 380.0),
    "SPRING": ("Coarse spring snow", "Melt forms, coarse and dense", 2950.0, 450.0),
}
"""Label, description, grain size in µm and density in kg/m³ of each kind of snow. Sizes have the specific surface area,
and densities are those, of the snow types fresh, rounded, wind-packed and melt forms; old settled snow is the default
of the package."""
MOST_SOOT_NG_G, MOST_DUST_NG_G = 1e5, 1e8
"""Impurities of sliders, within the ranges of :class:`snowblue.Snow`."""
PARAMETERS = _native.parameters()
PRESET_FACETNESS = PARAMETERS["facetness"]["default"]


def _number(key: str, margin: float = 0.0) -> Any:
    """The property of a parameter, whose range ends by a margin earlier."""
    parameter = PARAMETERS[key]
    unit = f" ({parameter['unit']})" if parameter["unit"] else ""
    return bpy.props.FloatProperty(
        name=f"{parameter['title'].title()}{unit}",
        description=f"{parameter['text']}. {parameter['effect'].removesuffix('.')}",
        min=parameter["least"] + margin,
        max=parameter["greatest"] - margin,
        default=parameter["default"],
    )


def _half_range_um() -> float:
    """Half of the range of sizes that a mean grain size stands for."""
    least, greatest = _native.Snows({}, {}, 1).common()["grain_size_um"]
    return (greatest - least) / 2


def _preset(name: str, description: str, prefix: str = "") -> Any:
    """The kind of snow, which sets the numbers whose names have a prefix."""

    def take(settings: SnowSettings, context: bpy.types.Context) -> None:
        kind = getattr(settings, f"{prefix}preset")
        if kind == "CUSTOM":
            return
        _, _, grain_size_um, density_kg_m3 = PRESETS[kind]
        numbers = {"grain_size_um": grain_size_um, "facetness": PRESET_FACETNESS, "density_kg_m3": density_kg_m3}
        for key, value in numbers.items():
            setattr(settings, prefix + key, value)

    return bpy.props.EnumProperty(
        name=name,
        description=description,
        items=[(key, label, text) for key, (label, text, *_) in PRESETS.items()]
        + [("CUSTOM", "Custom", "Numbers of your own")],
        default="OLD",
        update=take,
    )


def _impurity(name: str, what: str, greatest_ng_g: float) -> Any:
    return bpy.props.FloatProperty(
        name=f"{name} (ng/g)", description=f"Mass of {what} in the painted snow", min=0.0, max=greatest_ng_g
    )


class SnowSettings(bpy.types.PropertyGroup):
    """The snow of an object, and how an object is linked with its baked one."""

    is_snow: bpy.props.BoolProperty(name="Snow", description="Whether the object is snow")
    preset: _preset("Kind", "The kind of snow")
    grain_size_um: _number("grain_size_um", _half_range_um())
    facetness: _number("facetness")
    density_kg_m3: _number("density_kg_m3")
    body: bpy.props.StringProperty(
        name="Body",
        description="Objects with the same word are one solid of snow, such as the blocks of an igloo",
    )
    painted: bpy.props.StringProperty(
        name="Painted Group",
        description="A vertex group, as of a weight paint: the snow is the painted kind where the weight is 1, and in "
        "proportion where it is between 0 and 1",
    )
    painted_preset: _preset("Painted Kind", "The kind of snow where the vertex group has the weight 1", "painted_")
    painted_grain_size_um: _number("grain_size_um", _half_range_um())
    painted_facetness: _number("facetness")
    painted_density_kg_m3: _number("density_kg_m3")
    painted_soot_ng_g: _impurity("Soot", "black carbon", MOST_SOOT_NG_G)
    painted_dust_ng_g: _impurity("Dust", "Saharan dust", MOST_DUST_NG_G)
    source: bpy.props.PointerProperty(
        type=bpy.types.Object, name="Source", description="The object that a baked object was made of"
    )
    frames: bpy.props.PointerProperty(
        type=bpy.types.Collection, name="Frames", description="The objects that a baked object shows by the frame"
    )
    was_hidden_in_viewport: bpy.props.BoolProperty(description="Whether the viewport hid it before the bake")
    was_hidden_in_render: bpy.props.BoolProperty(description="Whether renders hid it before the bake")


def is_snow(thing: bpy.types.Object) -> bool:
    """Whether an object is marked as snow."""
    return thing.snowblue.is_snow


def baked_of(source: bpy.types.Object) -> bpy.types.Object | None:
    """The baked object of an object of snow."""
    return next((one for one in bpy.data.objects if one.snowblue.source == source), None)


def source_of(thing: bpy.types.Object) -> bpy.types.Object:
    """The object that the user marked: of a baked object its source, else the object."""
    return thing.snowblue.source or thing


def object_of(uid: int) -> bpy.types.Object | None:
    """The object with a `session_uid`."""
    return next((one for one in bpy.data.objects if one.session_uid == uid), None)


def scene_of(uid: int) -> bpy.types.Scene | None:
    """The scene with a `session_uid`."""
    return next((one for one in bpy.data.scenes if one.session_uid == uid), None)


NUMBERS = ("grain_size_um", "facetness", "density_kg_m3")


def snow_of(thing: bpy.types.Object) -> dict[str, float]:
    """The snow of an object, as of :class:`snowblue.Snow`."""
    return _numbers(thing.snowblue, "")


def painted_of(thing: bpy.types.Object) -> dict[str, Any] | None:
    """The snow of an object where its vertex group has the weight 1; none without a vertex group."""
    settings = thing.snowblue
    if not settings.painted:
        return None
    amounts = {"black-carbon": settings.painted_soot_ng_g, "saharan-dust": settings.painted_dust_ng_g}
    impurities = {name: round(value, 5) for name, value in amounts.items() if value > 0}
    return _numbers(settings, "painted_") | ({"impurities_ng_g": impurities} if impurities else {})


def _numbers(settings: SnowSettings, prefix: str) -> dict[str, float]:
    # Blender keeps 32-bit numbers, which may lie outside a range by rounding.
    return {name: round(getattr(settings, prefix + name), 5) for name in NUMBERS}
