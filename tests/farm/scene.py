"""Makes the scene of the farm tests, a ball of metal that moves: `python scene.py FILE.blend`."""

import sys

import bpy

bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
scene.cycles.samples, scene.frame_end = 4, 2
bpy.ops.mesh.primitive_uv_sphere_add(location=(0.0, 0.0, 1.0))
ball = bpy.context.object
metal = bpy.data.materials.new("Copper")
metal.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
metal.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.9, 0.5, 0.3, 1.0)
ball.data.materials.append(metal)
for frame, place in ((1, -0.5), (2, 0.5)):
    ball.location.x = place
    ball.keyframe_insert("location", frame=frame)
bpy.ops.mesh.primitive_plane_add(size=8.0)
bpy.ops.object.camera_add(location=(0.0, -6.0, 2.5), rotation=(1.3, 0.0, 0.0))
scene.camera = bpy.context.object
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])
