"""Snow in Blender.

>>> import bpy
>>> import snowblue.blender
>>> snowblue.blender.register()
>>> block = bpy.context.object
>>> block.snowblue.is_snow = True
>>> block.snowblue.preset = "OLD"
>>> [baked] = snowblue.blender.bake()

`register` gives objects the settings of snow, and Blender the panel "Snow" in the sidebar of its 3D view. `bake` solves
for the light in all snow, at one frame or several, and makes objects with the light as attributes; `clear` removes
them. Snow must be a closed mesh; it is lit by lamps (point, spot, sun, area) and by the World. The settings of an
object, `object.snowblue`, are `is_snow`, `preset` ("FRESH", "SETTLED", "OLD", "WIND", "SPRING", "CUSTOM"),
`grain_size_um`, `facetness` and `density_kg_m3` in the ranges of `snowblue.parameters`, and `body`: objects with the
same word there are one solid.
"""

from snowblue.blender._bake import bake, clear
from snowblue.blender._panel import register, unregister

__all__ = ["bake", "clear", "register", "unregister"]
