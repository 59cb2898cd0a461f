# Shows a baked file of snow: godot --path examples/godot -- "$PWD/block.glb" ["$PWD/picture.png"]
#
# With a second name it writes a picture and ends. Units are metres, y is up.
extends Node3D


func _ready() -> void:
	var names := OS.get_cmdline_user_args()
	if names.is_empty():
		return _fail("usage: godot --path examples/godot -- FILE.glb [PICTURE.png]")
	var state := GLTFState.new()
	var document := GLTFDocument.new()
	var error := document.append_from_file(names[0], state)
	if error != OK:
		return _fail("%s cannot be read: %s" % [names[0], error_string(error)])
	add_child(document.generate_scene(state))
	# The view of scenes/block_30cm.toml, whose z is y here.
	$Camera.look_at_from_position(Vector3(1.2, 0.7, 1.6), Vector3(0, 0.27, 0))
	if names.size() > 1:
		await RenderingServer.frame_post_draw
		await RenderingServer.frame_post_draw
		error = get_viewport().get_texture().get_image().save_png(names[1])
		if error != OK:
			return _fail("%s cannot be written: %s" % [names[1], error_string(error)])
		get_tree().quit()


func _fail(message: String) -> void:
	printerr(message)
	get_tree().quit(1)
