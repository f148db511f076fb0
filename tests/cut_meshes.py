"""Meshes to cut, and measures of what came out: Euler characteristic, area, volume, a flood fill. Import after bpy.

Holds no tests; `measure` asserts that no edge has more than two faces.
"""

from types import SimpleNamespace

import numpy as np

import bpy

import bmesh

from blender_scenes import add_mesh_object


def add_ball(kind):
    """A closed ball of quads (with triangles at the poles), triangles, or many-cornered faces."""
    if kind == "quads":
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=14)
    else:
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    ball = bpy.context.object
    if kind == "n-gons":  # the dual: twelve pentagons among hexagons
        edited = bmesh.new()
        edited.from_mesh(ball.data)
        places = [tuple(face.calc_center_median().normalized()) for face in edited.faces]
        edited.faces.index_update()
        faces = []
        for vertex in edited.verts:
            loops, loop = [], vertex.link_loops[0]
            for _ in vertex.link_loops:
                loops.append(loop.face.index)
                loop = loop.link_loop_prev.link_loop_radial_next
            faces.append(loops[::-1])
        edited.free()
        bpy.data.objects.remove(ball)
        ball = add_mesh_object("Ball", places, faces)
        bpy.context.view_layer.objects.active = ball
        ball.select_set(True)
    assert ball.data.validate() is False
    return ball


def measure(mesh):
    """Euler characteristic, area, volume and the number of border edges, of the loop triangles."""
    mesh.calc_loop_triangles()
    places = np.array([v.co for v in mesh.vertices], dtype=np.float64)
    triangles = np.array([t.vertices for t in mesh.loop_triangles])
    a, b, c = (places[triangles[:, k]] for k in range(3))
    uses = np.bincount([loop.edge_index for loop in mesh.loops], minlength=len(mesh.edges))
    assert uses.max() == 2
    return SimpleNamespace(
        euler=len(mesh.vertices) - len(mesh.edges) + len(mesh.polygons),
        area=np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2,
        volume=np.einsum("ij,ij->", a, np.cross(b, c)) / 6,
        border=int((uses == 1).sum()),
    )


def flood(mesh, walls):
    """Parts of the faces when no step leads over the edges in `walls`: a number for each face."""
    faces_of = {}
    for polygon in mesh.polygons:
        for loop in polygon.loop_indices:
            faces_of.setdefault(mesh.loops[loop].edge_index, []).append(polygon.index)
    neighbours = {polygon.index: [] for polygon in mesh.polygons}
    for edge, faces in faces_of.items():
        if edge not in walls and len(faces) == 2:
            neighbours[faces[0]].append(faces[1])
            neighbours[faces[1]].append(faces[0])
    part = {}
    for start in neighbours:
        if start in part:
            continue
        front, number = [start], len(set(part.values()))
        while front:
            face = front.pop()
            if face not in part:
                part[face] = number
                front += neighbours[face]
    return np.array([part[p.index] for p in mesh.polygons])


def seam_edges(mesh):
    return {edge.index for edge in mesh.edges if edge.use_seam}


def circle_on_ball(height, count=50, tilt=0.3):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    radius = np.sqrt(1 - height**2)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, height)])
    turn = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    return points @ turn.T
