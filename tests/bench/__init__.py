"""Our library beside the ones that a user could take instead, on the same queries: `make bench`.

Measures and tells; holds no test and gates on no time. `python -m bench --help`, with `tests` in PYTHONPATH.
"""
