"""Tests of the Python binding, and of the core through it."""
