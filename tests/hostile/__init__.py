"""Every filter on every mesh that could hurt it: `make hostile` runs it, `tests/native/test_hostile_run.py` a part."""
