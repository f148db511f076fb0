"""Lines through the same picks on a bumpy ball, in one picture with PyVista: how the filters differ.

A notebook of cells (Jupytext, VS Code and Spyder open it as such), and a script: `python examples/pyvista_line.py
picture.png` makes the picture without a window. Needs `pip install 'smooth-polylines[plot]'`.
"""

# %% A mesh: positions and triangles as numpy arrays.
import sys

import numpy as np
import pyvista as pv

import smooth_polylines as sp

ball = pv.Sphere(radius=1.0, theta_resolution=90, phi_resolution=60)
normals = np.asarray(ball.points, dtype=np.float64)
bumps = 0.08 * np.sin(6 * normals[:, 0]) * np.cos(5 * normals[:, 1] + 1) * np.sin(4 * normals[:, 2])
positions = normals * (1 + bumps)[:, None]
triangles = ball.regular_faces

# %% Picks: the points of the surface nearest to places in space.
mesh = sp.SurfaceMesh(positions, triangles)
places = np.array([[-0.9, -0.5, -0.3], [-0.35, -0.9, 0.35], [0.25, -0.95, -0.35], [0.85, -0.45, 0.5]])
picks = mesh.closest_points(places).surface_points

# %% The same picks, three filters.
lines = {
    "geodesic": mesh.polyline(picks, filter="geodesic"),
    "cubic": mesh.polyline(picks, filter="cubic", threshold=1e-2),
    "fair": mesh.polyline(picks, filter="fair", pinned="all"),
}
for name, line in lines.items():
    print(f"{name}: {len(line.points)} points, length {line.length:.3f}, {line.report.stop_reason}")

# %% The picture.
COLOURS = {"geodesic": "#1769c4", "cubic": "#e08a00", "fair": "#c81e3c"}
picture = sys.argv[1] if len(sys.argv) > 1 else None
plotter = pv.Plotter(off_screen=picture is not None, window_size=(800, 640))
surface = pv.PolyData.from_regular_faces(positions, triangles)
plotter.add_mesh(surface, color="#d5d8dc", smooth_shading=True, show_edges=True, edge_color="#c2c6cb")
for name, line in lines.items():
    tube = pv.lines_from_points(line.points).tube(radius=0.014)
    plotter.add_mesh(tube, color=COLOURS[name], label=name)
shown = np.array([np.asarray(p.barycentric) @ positions[triangles[p.triangle]] for p in picks])
plotter.add_points(shown, color="black", point_size=18, render_points_as_spheres=True)
plotter.add_legend(bcolor="white", face="rectangle")
plotter.camera_position = [(0.5, -4.6, 0.8), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
plotter.show(screenshot=picture)
