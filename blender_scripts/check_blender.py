"""Tells whether the bpy module of this environment can be used, and what to install when it cannot.

Holds no installing: it prints the command and leaves running it to the person.
"""

import sys
from pathlib import Path

PACKAGES = Path(__file__).resolve().parents[1] / ".ci" / "debian-packages.txt"


def main() -> int:
    """0 when Blender's module loads, 1 with advice when a system library is missing."""
    try:
        import bpy
    except ImportError as error:
        print(f"Blender's Python module (bpy) does not load here: {error}", file=sys.stderr)
        if ".so" in str(error):
            names = " ".join(PACKAGES.read_text().split())
            print("It needs a few system libraries. On Debian or Ubuntu, as root:", file=sys.stderr)
            print(f"    apt-get install --no-install-recommends {names}", file=sys.stderr)
            print("Then run the same make command again.", file=sys.stderr)
        return 1
    print(f"Blender {bpy.app.version_string} (bpy) with Python {sys.version.split()[0]} is ready.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
