"""A mesh of ten million triangles: `make huge` opens it, searches across it, and tells time and memory."""
