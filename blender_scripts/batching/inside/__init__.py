"""What a worker process does in Blender with one file. Everything in here may import bpy; nothing outside does."""
