

def snow_material(name="Snow"):
    """The material of this name, made or changed to this snow."""
    if bpy.app.version < (4, 0):
        raise RuntimeError(f"Blender is {bpy.app.version_string}, but must be 4.0 or later")
    material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    surface, output = nodes.new("ShaderNodeBsdfPrincipled"), nodes.new("ShaderNodeOutputMaterial")
    output.location.x = 300
    methods = surface.bl_rna.properties["subsurface_method"].enum_items.keys()
    # What Blender 5.0 calls Random Walk is legacy in later versions.
    surface.subsurface_method = "RANDOM_WALK_LEGACY" if "RANDOM_WALK_LEGACY" in methods else "RANDOM_WALK"
    for socket, value in SOCKETS.items():
        surface.inputs[socket].default_value = value
    links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return material


if __name__ == "__main__":
    snow_material()
