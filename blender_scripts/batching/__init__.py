"""What `batch.py` is made of: the run outside Blender, and in `inside` what its worker processes do in Blender.

Outside nothing imports bpy, so a run can be started, checked and watched by any Python from 3.11 on.
"""
