"""Things to light: the gold pedestal, the small silver ball and the large copper ball of the paper's fig. 12."""

import math
from collections.abc import Sequence

import bpy
from mathutils import Vector

from .materials import metal_colours

PEDESTAL_HEIGHT_M = 0.50
SILVER_RADIUS_M = 0.07
COPPER_RADIUS_M = 0.17
TABLE_RADIUS_M = 0.60

type Point = tuple[float, float]

# Half section of the pedestal, (radius, height) in metres from the middle of its foot to the middle of its top; the third number
# rounds the corner. Plinth, foot moulding, waisted shaft, neck moulding, table.
_SECTION: tuple[tuple[float, float, float], ...] = (
    (0.000, 0.000, 0.0),
    (0.190, 0.000, 0.004),
    (0.190, 0.045, 0.006),
    (0.168, 0.045, 0.003),
    (0.168, 0.070, 0.012),
    (0.145, 0.070, 0.003),
    (0.138, 0.084, 0.006),
    (0.112, 0.110, 0.030),
    (0.098, 0.250, 0.220),
    (0.108, 0.400, 0.030),
    (0.122, 0.408, 0.003),
    (0.122, 0.424, 0.007),
    (0.112, 0.428, 0.002),
    (0.142, 0.456, 0.025),
    (0.150, 0.460, 0.002),
    (0.150, 0.500, 0.006),
    (0.000, 0.500, 0.0),
)


def scale_beside_ball(ball_radius_m: float) -> float:
    """The scale at which the copper ball is as large as the mirrored ball that stood there, and the others go with it."""
    return ball_radius_m / COPPER_RADIUS_M


def add_gold_pedestal(
    collection: bpy.types.Collection, location: Sequence[float] = (0.0, 0.0, 0.0), scale: float = 1.0
) -> bpy.types.Object:
    """Add a turned pedestal of gold, half a metre high at scale 1, standing on `location`."""
    section = [(radius * scale, height * scale) for radius, height in _rounded(_SECTION)]
    pedestal = bpy.data.objects.new("Gold Pedestal", _turned("Gold Pedestal", section))
    return _placed(pedestal, collection, location, metal_material("Gold", "Au", roughness=0.16))


def add_silver_ball(
    collection: bpy.types.Collection,
    location: Sequence[float] = (0.0, 0.0, PEDESTAL_HEIGHT_M),
    scale: float = 1.0,
) -> bpy.types.Object:
    """Add the small ball of silver, standing on `location` (by default, the pedestal's top)."""
    ball = _ball("Silver Ball", SILVER_RADIUS_M * scale)
    return _placed(ball, collection, location, metal_material("Silver", "Ag", roughness=0.05))


def add_copper_ball(
    collection: bpy.types.Collection, location: Sequence[float] = (0.42, -0.12, 0.0), scale: float = 1.0
) -> bpy.types.Object:
    """Add the large ball of copper, standing on `location` (by default, on the floor beside the pedestal)."""
    ball = _ball("Copper Ball", COPPER_RADIUS_M * scale)
    return _placed(ball, collection, location, metal_material("Copper", "Cu", roughness=0.24))


def add_metals(
    collection: bpy.types.Collection,
    at: Sequence[float] = (0.0, 0.0, 0.0),
    bearing_deg: float = 0.0,
    scale: float = 1.0,
) -> list[bpy.types.Object]:
    """Add the group of the paper's fig. 12, standing round `at`, as one sees it who looks along a compass bearing.

    The pedestal with the silver ball on it is to the left, the copper ball to the right and nearer.
    """
    across, ahead = _axes(bearing_deg)
    at = Vector(at)

    def place(right: float, forward: float, up: float) -> Vector:
        return at + (across * right + ahead * forward + Vector((0.0, 0.0, up))) * scale

    return [
        add_gold_pedestal(collection, place(-0.14, 0.05, 0.0), scale),
        add_silver_ball(collection, place(-0.14, 0.05, PEDESTAL_HEIGHT_M), scale),
        add_copper_ball(collection, place(0.23, -0.10, 0.0), scale),
    ]


def metal_material(name: str, metal: str, roughness: float) -> bpy.types.Material:
    """A metal for spectral and for ordinary renders; one that is there already is used again.

    The spectral passes take n and k from `Material.spectral_probe`; the node's colours are the metal's under D65.
    """
    known = bpy.data.materials.get(name)
    if known is not None and (known.spectral_probe.kind, known.spectral_probe.metal) == ("METAL", metal):
        return known
    material = bpy.data.materials.new(name)
    material.spectral_probe.kind = "METAL"
    material.spectral_probe.metal = metal
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfMetallic"), tree.nodes.new("ShaderNodeOutputMaterial")
    output.location = (300.0, 0.0)
    facing, tint = metal_colours(metal)
    shader.inputs["Base Color"].default_value = (*facing, 1.0)
    shader.inputs["Edge Tint"].default_value = (*tint, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    material.diffuse_color = (*facing, 1.0)
    material.metallic, material.roughness = 1.0, roughness
    return material


def demo_scene(scene: bpy.types.Scene, bearing_deg: float = 0.0) -> None:
    """Furnish an empty scene as the paper's fig. 12: a round table, pedestal, balls and a camera, for Cycles.

    Parameters
    ----------
    scene
        An empty scene. The light is to be added: the panorama is also what stands behind.
    bearing_deg
        Compass bearing along which the camera looks, 0 = +Y, clockwise seen from above.
    """
    scene.render.engine = "CYCLES"
    add_table(scene.collection)
    add_metals(scene.collection, bearing_deg=bearing_deg)
    data = bpy.data.cameras.new("Camera")
    camera = bpy.data.objects.new("Camera", data)
    aim_at_metals(camera, bearing_deg=bearing_deg)
    # Between the pedestal's front and the copper ball's; the panorama is out of focus, as it is in photographs.
    data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = True, 1.32, 1.4
    scene.collection.objects.link(camera)
    scene.camera = camera


def aim_at_metals(
    camera: bpy.types.Object,
    at: Sequence[float] = (0.0, 0.0, 0.0),
    bearing_deg: float = 0.0,
    scale: float = 1.0,
) -> None:
    """Place a camera before the group that `add_metals` adds, so that it fills a wide picture."""
    across, ahead = _axes(bearing_deg)
    camera.data.lens, camera.data.shift_y = 29.0, 0.045  # level and shifted upwards: verticals stay upright
    camera.location = Vector(at) + (across * 0.04 - ahead * 1.45 + Vector((0.0, 0.0, 0.36))) * scale
    camera.rotation_euler = ahead.to_track_quat("-Z", "Y").to_euler()


def add_table(collection: bpy.types.Collection) -> bpy.types.Object:
    """Add a round table top of pale stone with a rounded edge, its top at z = 0."""
    edge_m, thick_m = 0.012, 0.045
    section = [
        (0.0, -thick_m, 0.0),
        (TABLE_RADIUS_M, -thick_m, edge_m),
        (TABLE_RADIUS_M, 0.0, edge_m),
        (0.0, 0.0, 0.0),
    ]
    table = bpy.data.objects.new("Table", _turned("Table", _rounded(section), 256))
    stone = bpy.data.materials.new("Table")
    tree = stone.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (0.46, 0.45, 0.43, 1.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return _placed(table, collection, (0.0, 0.0, 0.0), stone)


def _axes(bearing_deg: float) -> tuple[Vector, Vector]:
    """To the right and ahead, on the ground, of one who looks along a compass bearing."""
    bearing = math.radians(bearing_deg)
    east, north = math.sin(bearing), math.cos(bearing)
    return Vector((north, -east, 0.0)), Vector((east, north, 0.0))


def _placed(
    thing: bpy.types.Object,
    collection: bpy.types.Collection,
    location: Sequence[float],
    material: bpy.types.Material,
) -> bpy.types.Object:
    thing.location = location
    thing.data.materials.append(material)
    collection.objects.link(thing)
    return thing


def _ball(name: str, radius_m: float) -> bpy.types.Object:
    """A ball whose lowest point is its origin, fine enough that a mirror's reflections are smooth."""
    steps = 128
    half_circle = [
        (radius_m * math.sin(math.pi * i / steps), radius_m * (1.0 - math.cos(math.pi * i / steps)))
        for i in range(steps + 1)
    ]
    half_circle[0], half_circle[-1] = (0.0, 0.0), (0.0, 2.0 * radius_m)
    return bpy.data.objects.new(name, _turned(name, half_circle, 256))


def _rounded(section: Sequence[tuple[float, float, float]], steps: int = 8) -> list[Point]:
    """A section (radius, height, rounding) with its corners rounded by quadratic curves.

    A support point on either side of each curve keeps the shading of the flats flat.
    """
    rounded: list[Point] = [section[0][:2]]
    for before, corner, after in zip(section, section[1:], section[2:], strict=False):
        here = Vector(corner[:2])
        arms = [Vector(other[:2]) - here for other in (before, after)]
        reach = min(corner[2], *(0.45 * arm.length for arm in arms))
        start, end = (here + arm.normalized() * reach for arm in arms)
        rounded.append(tuple(here + arms[0].normalized() * reach * 1.1))
        for i in range(steps + 1):
            t = i / steps
            rounded.append(tuple(start * (1 - t) ** 2 + here * 2 * t * (1 - t) + end * t**2))
        rounded.append(tuple(here + arms[1].normalized() * reach * 1.1))
    return [*rounded, section[-1][:2]]


def _turned(name: str, section: Sequence[Point], segments: int = 192) -> bpy.types.Mesh:
    """A body of revolution about z from its half section (radius, height), which begins and ends on the axis."""
    rings = section[1:-1]
    turns = [
        (math.cos(2 * math.pi * s / segments), math.sin(2 * math.pi * s / segments)) for s in range(segments)
    ]
    vertices = [(0.0, 0.0, section[0][1]), (0.0, 0.0, section[-1][1])]
    vertices += [(radius * x, radius * y, height) for radius, height in rings for x, y in turns]

    def vertex(ring: int, segment: int) -> int:
        return 2 + ring * segments + segment % segments

    last = len(rings) - 1
    faces: list[tuple[int, ...]] = []
    for s in range(segments):
        faces.append((0, vertex(0, s + 1), vertex(0, s)))
        faces += [
            (vertex(r, s), vertex(r, s + 1), vertex(r + 1, s + 1), vertex(r + 1, s)) for r in range(last)
        ]
        faces.append((1, vertex(last, s), vertex(last, s + 1)))
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.shade_smooth()
    return mesh
