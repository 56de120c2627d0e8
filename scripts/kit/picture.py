"""The picture of a loaded Blender scene: Cycles on the processor, which needs no display.

Needs bpy. Everything is placed relative to the bounds of what is in the scene, so that metres and
millimetres give the same picture.
"""

import math
from pathlib import Path

import bpy
from kit.quiet import quiet
from mathutils import Vector

VIEW = Vector((0.62, 1.0, 0.32))
"""Where the camera stands, seen from the middle: in front, to the right, a little above (RAS)."""
LIGHTS = {
    "key": ((1.6, 1.2, 1.4), 1.0),
    "fill": ((-1.6, 1.2, 0.4), 0.3),
    "rim": ((-0.4, -1.6, 1.6), 1.2),
}
"""Direction from the middle, and power at unit distance and unit size."""


def render(path: Path) -> None:
    """Lights, frames and renders the meshes of the scene."""
    corners = [
        item.matrix_world @ Vector(corner)
        for item in bpy.data.objects
        if item.type == "MESH"
        for corner in item.bound_box
    ]
    low, high = (Vector(map(pick, zip(*corners))) for pick in (min, max))
    middle, radius = (low + high) / 2, (high - low).length / 2
    for name, (direction, power) in LIGHTS.items():
        light(name, middle, Vector(direction), power, radius)
    camera(middle, radius)
    background()
    settings(path)
    with quiet():
        bpy.ops.render.render(write_still=True)


def looking(name: str, data: object, place: Vector, target: Vector) -> bpy.types.Object:
    """Puts a camera or a lamp somewhere, turned to a point."""
    item = bpy.data.objects.new(name, data)
    item.location = place
    item.rotation_euler = (target - place).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(item)
    return item


def light(name: str, middle: Vector, direction: Vector, power: float, radius: float) -> None:
    """A soft lamp at three radii, as bright for a head in metres as for a part in millimetres."""
    data = bpy.data.lights.new(name, "AREA")
    data.size = 1.5 * radius
    data.energy = power * 60 * radius**2
    looking(name, data, middle + direction.normalized() * 3 * radius, middle)


def camera(middle: Vector, radius: float) -> None:
    """Far enough that the bounding sphere fits the shorter side."""
    data = bpy.data.cameras.new("camera")
    data.angle = math.radians(30)
    distance = radius / math.sin(data.angle / 2) * 1.02
    data.clip_start, data.clip_end = distance / 100, distance * 100
    place = middle + VIEW.normalized() * distance
    bpy.context.scene.camera = looking("camera", data, place, middle)


def background() -> None:
    """A light grey for the eye, a dimmer one for the surfaces, so that their shading shows."""
    world = bpy.data.worlds.new("background")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    shader = nodes["Background"]
    shader.inputs["Color"].default_value = (0.80, 0.82, 0.85, 1)
    strength = nodes.new("ShaderNodeMapRange")
    strength.inputs["To Min"].default_value = 0.25
    strength.inputs["To Max"].default_value = 1.0
    ray = nodes.new("ShaderNodeLightPath")
    links.new(ray.outputs["Is Camera Ray"], strength.inputs["Value"])
    links.new(strength.outputs["Result"], shader.inputs["Strength"])


def settings(path: Path) -> None:
    """Few samples and the denoiser; enough transparent bounces for a skin with folds."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = 48
    scene.cycles.use_denoising = True
    scene.cycles.transparent_max_bounces = 32
    scene.render.resolution_x, scene.render.resolution_y = 800, 600
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = str(path.resolve())
