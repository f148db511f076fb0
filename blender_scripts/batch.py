"""The same curves over thousands of files, without a window. See docs/batch.md.

    python blender_scripts/batch.py JOB.json                        with the bpy module
    python blender_scripts/batch.py JOB.json --blender PROGRAM      with a Blender that has the extension
    blender -b FILE -P blender_scripts/batch.py -- JOB.json         inside one

Only the door: what is behind it lies in `batching`.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from batching import command_line


def main() -> None:
    """Run the command and end the process with its exit code."""
    bpy = sys.modules.get("bpy")
    if bpy is not None and bpy.app.binary_path:
        after = sys.argv.index("--") + 1 if "--" in sys.argv else len(sys.argv)
        code = command_line.main(sys.argv[after:], blender=bpy.app.binary_path, open_file=bpy.data.filepath)
    else:
        code = command_line.main(sys.argv[1:])
    command_line.leave(code)


if __name__ == "__main__":
    main()
