"""A cloud in Blender's Cycles, for cloud.py: blender -b -P cycles_cloud.py -- SCENE.json OUT.exr. Run by Blender's Python.

Light is scattered once. A sun of pi W/m2 and a phase of 1 / (4 pi) send a quarter of what Kiln's light of 1 sends.
Cycles reads a voxel half a voxel beside the place that OpenVDB gives it; the object is moved back."""

import json
import math
import sys

import bpy
from mathutils import Matrix, Vector

scene_path, out = sys.argv[sys.argv.index("--") + 1:]
with open(scene_path) as file:
    wanted = json.load(file)

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.samples = wanted["samples"]
scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
scene.cycles.max_bounces, scene.cycles.volume_bounces = 1, 0
scene.cycles.volume_step_rate, scene.cycles.volume_max_steps = 0.5, 4096
scene.cycles.pixel_filter_type = "BOX"
scene.render.resolution_x = scene.render.resolution_y = wanted["size"]
scene.render.film_transparent = True

grid = bpy.data.volumes.new("cloud")
grid.filepath = wanted["cloud"]
placed = bpy.data.objects.new("cloud", grid)
placed.location = [-edge / 2 for edge in wanted["voxel"]]
scene.collection.objects.link(placed)
material = bpy.data.materials.new("medium")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
medium, output = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
links.new(medium.outputs[0], output.inputs["Volume"])
medium.inputs["Color"].default_value = (1, 1, 1, 1)
medium.inputs["Density"].default_value = wanted["extinction"]
medium.inputs["Density Attribute"].default_value = wanted["grid"]
medium.inputs["Anisotropy"].default_value = wanted["anisotropy"]
grid.materials.append(material)

sun = bpy.data.lights.new("sun", "SUN")
sun.energy, sun.angle = math.pi, 0
lit = bpy.data.objects.new("sun", sun)
lit.rotation_euler = Vector(wanted["light"]).to_track_quat("Z", "Y").to_euler()
scene.collection.objects.link(lit)
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0

eye, target, up = (Vector(wanted[key]) for key in ("eye", "target", "up"))
z = (eye - target).normalized()
x = up.cross(z).normalized()
y = z.cross(x)
lens = bpy.data.cameras.new("camera")
lens.sensor_fit, lens.angle = "VERTICAL", math.radians(wanted["fov"])
lens.clip_start, lens.clip_end = 1e-3 * (eye - target).length, 10 * (eye - target).length
camera = bpy.data.objects.new("camera", lens)
camera.matrix_world = Matrix([(x[i], y[i], z[i], eye[i]) for i in range(3)] + [(0, 0, 0, 1)])
scene.collection.objects.link(camera)
scene.camera = camera

scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
