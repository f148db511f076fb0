"""What the benchmark ran on, in words that name no host and no path."""

import os
import platform
from pathlib import Path

import numpy as np


def describe():
    """Processor, cores, memory, system and Python; read when it runs."""
    return {
        "processor": find_processor(),
        "cores": os.cpu_count(),
        "memory": find_memory(),
        "system": find_system(),
        "Python": platform.python_version(),
        "numpy": np.__version__,
    }


def find_processor():
    info = Path("/proc/cpuinfo")
    if info.exists():
        rows = (line.split(":", 1) for line in info.read_text().splitlines() if ":" in line)
        fields = {key.strip(): value.strip() for key, value in rows}
        if "model name" in fields:
            family = f"family {fields.get('cpu family', '?')} model {fields.get('model', '?')}"
            return f"{fields['model name']} ({family}, {fields.get('cache size', '?')} cache a core)"
    return platform.processor() or platform.machine()


def find_memory():
    info = Path("/proc/meminfo")
    if not info.exists():
        return "unknown"
    kilobytes = int(info.read_text().split("MemTotal:")[1].split()[0])
    return f"{kilobytes / 2**20:.0f} GiB"


def find_system():
    try:
        name = platform.freedesktop_os_release()["PRETTY_NAME"]
    except OSError:
        name = platform.system()
    return f"{name}, {platform.system()} {platform.release().split('-')[0]}, {platform.machine()}"
