

def snow_material(name="Snow"):
    """The material of this name, made or changed to this snow."""
    # Versions after 5.1 have another Random Walk, which reads the same numbers in another way.
    method = "RANDOM_WALK" if bpy.app.version < (5, 2) else "RANDOM_WALK_LEGACY"
    methods = bpy.types.ShaderNodeBsdfPrincipled.bl_rna.properties["subsurface_method"].enum_items.keys()
    if bpy.app.version < (4, 0) or method not in methods:
        raise RuntimeError(f"Blender {bpy.app.version_string} does not have the random walk of Blender 4.0 to 5.1")
    material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    surface, output = nodes.new("ShaderNodeBsdfPrincipled"), nodes.new("ShaderNodeOutputMaterial")
    output.location.x = 300
    surface.subsurface_method = method
    for socket, value in SOCKETS.items():
        surface.inputs[socket].default_value = value
    links.new(surface.outputs["BSDF"], output.inputs["Surface"])
    return material


if __name__ == "__main__":
    snow_material()
