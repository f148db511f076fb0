"""What a worker process does inside Blender with one file. Everything in here may import bpy; nothing outside imports it."""
