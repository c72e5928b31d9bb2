# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by Blender: draws a glTF with Cycles as the truth of a Sightline image says.

blender -b --factory-startup -P in_blender.py -- MODEL.gltf TRUTH.json OUT.exr {dull|principled} [PANORAMA.exr]
"""
import json
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

SAMPLES = 128
# glTF's y is Blender's z.
BLENDER_FROM_FILE = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)
# A panorama's middle lies along Blender's x, its top along z; of ours along the camera's z and -y.
PANORAMA_FROM_CAM = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], float)


def import_model(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    np.bool = bool  # Debian's importer is older than Debian's numpy
    bpy.ops.import_scene.gltf(filepath=path)


def add(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(thing)
    return thing


def set_camera(camera, blender_from_cam, position):
    data = bpy.data.cameras.new("camera")
    data.sensor_width = 36
    data.lens = 36 * camera["fx_px"] / camera["width_px"]
    data.clip_start, data.clip_end = 1e-3, 1e6
    pose = np.eye(4)
    pose[:3, :3] = blender_from_cam @ np.diag([1, -1, -1])
    pose[:3, 3] = position
    thing = add("camera", data)
    thing.matrix_world = Matrix(pose.tolist())
    bpy.context.scene.camera = thing


def set_light(light, blender_from_cam, panorama):
    if light["directional"] > 0:
        data = bpy.data.lights.new("sun", "SUN")
        data.energy = np.pi * light["directional"]  # ours is the grey of a white surface facing it
        data.angle = 0
        direction = Vector((blender_from_cam @ np.array(light["to_light_in_cam"])).tolist())
        add("sun", data).rotation_euler = direction.to_track_quat("Z", "Y").to_euler()
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    background.inputs[0].default_value = (1, 1, 1, 1)
    background.inputs[1].default_value = light["ambient"]
    if panorama is None:
        return
    background.inputs[1].default_value = 1
    picture = nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(panorama)
    turn = nodes.new("ShaderNodeMapping")
    turn.vector_type = "POINT"
    turned = PANORAMA_FROM_CAM @ blender_from_cam.T
    turn.inputs["Rotation"].default_value = Matrix(turned.tolist()).to_euler("XYZ")
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Generated"], turn.inputs["Vector"])
    links.new(turn.outputs[0], picture.inputs[0])
    links.new(picture.outputs[0], background.inputs[0])


def decode(image):
    """The picture in linear light: Cycles blends the texels of encoded ones before it decodes them."""
    texels = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(texels)
    texels = texels.reshape(-1, 4)
    colours = texels[:, :3]
    texels[:, :3] = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    linear = bpy.data.images.new(image.name + " linear", *image.size, alpha=True, float_buffer=True)
    linear.colorspace_settings.name = "Linear"
    linear.alpha_mode = "CHANNEL_PACKED"
    linear.pixels.foreach_set(texels.ravel())
    return linear


def set_materials(is_dull):
    for material in bpy.data.materials:
        nodes, links = material.node_tree.nodes, material.node_tree.links
        for node in nodes:
            if node.type == "TEX_IMAGE" and node.image.colorspace_settings.name == "sRGB":
                node.image = decode(node.image)
        if not is_dull:
            continue
        surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
        out = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
        dull = nodes.new("ShaderNodeBsdfDiffuse")
        dull.inputs[0].default_value = surface.inputs["Base Color"].default_value
        for link in surface.inputs["Base Color"].links:
            links.new(link.from_socket, dull.inputs[0])
        links.new(dull.outputs[0], out.inputs[0])


def draw(camera, out):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples = SAMPLES
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    cycles.light_sampling_threshold = 0
    # What comes from lights and sky alone; with none at all Cycles loses a part of the sky's.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 1
    render = scene.render
    render.film_transparent = True
    render.resolution_x, render.resolution_y = camera["width_px"], camera["height_px"]
    render.resolution_percentage = 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = out
    bpy.ops.render.render(write_still=True)


def main():
    model, truth_path, out, kind, *rest = sys.argv[sys.argv.index("--") + 1:]
    with open(truth_path, encoding="utf-8") as file:
        truth = json.load(file)
    pose = truth["bodies"][0]["cam_from_target"]
    file_from_cam = np.array(pose["rotation"]).reshape(3, 3).T
    blender_from_cam = BLENDER_FROM_FILE @ file_from_cam
    import_model(model)
    set_camera(truth["camera"], blender_from_cam, -blender_from_cam @ np.array(pose["translation_m"]))
    set_light(truth["scene"]["light"], blender_from_cam, rest[0] if rest else None)
    set_materials(kind == "dull")
    draw(truth["camera"], out)


main()
