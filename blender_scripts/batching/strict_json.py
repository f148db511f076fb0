"""Reads JSON as the standard has it: UTF-8, finite numbers, no key twice, no endless nesting. Knows no jobs."""

import json
import math
import re
from pathlib import Path
from typing import Any

from .errors import JobError

LARGEST_FILE = 64_000_000  # bytes; ten thousand inputs named one by one take about one million
DEEPEST = 64  # levels of [ and {; a job has nine
# A whole string (or one that never ends), or a bracket outside of strings.
TOKEN = re.compile(r'"(?:[^"\\]++|\\.)*+(?:"|\Z)|[\[\]{}]', re.DOTALL)


def read_json(path: Path) -> Any:
    """The value in the file at `path`; JobError with one line that says what is wrong."""
    try:
        size = path.stat().st_size
        if size > LARGEST_FILE:
            raise JobError(f"{path} has {size} bytes, more than the {LARGEST_FILE} that a job may have")
        data = path.read_bytes()
    except OSError as error:
        raise JobError(f"{path} cannot be read: {error.strerror or error}") from error
    return parse_json(data, str(path))


def parse_json(data: bytes, name: str) -> Any:
    """The value that `data` holds; `name` says in messages where it came from."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise JobError(f"{name} is not UTF-8 text (byte {error.start}); save it as UTF-8") from error
    try:
        check_depth(text, name)
        return json.loads(
            text,
            parse_constant=lambda word: _refuse(f"{name}: {word} is no JSON number; use finite numbers"),
            parse_float=lambda word: _parse_finite(word, name),
            object_pairs_hook=lambda pairs: _make_object(pairs, name),
        )
    except json.JSONDecodeError as error:
        raise JobError(f"{name}, line {error.lineno}, column {error.colno}: no JSON here: {error.msg}") from error
    except RecursionError as error:
        raise JobError(f"{name} is nested too deeply") from error
    except ValueError as error:  # an integer of thousands of digits
        raise JobError(f"{name}: a number cannot be read: {str(error).split(';')[0]}") from error


def check_depth(text: str, name: str) -> None:
    """JobError where brackets are nested deeper than any job; brackets in strings do not count."""
    depth = 0
    for match in TOKEN.finditer(text):
        letter = match[0][0]
        if letter in "[{":
            depth += 1
            if depth > DEEPEST:
                line = text.count("\n", 0, match.start()) + 1
                raise JobError(
                    f"{name}, line {line}: more than {DEEPEST} levels of brackets; a job has no use for them"
                )
        elif letter in "]}":
            depth -= 1


def _refuse(message: str) -> Any:
    raise JobError(message)


def _parse_finite(word: str, name: str) -> float:
    number = float(word)
    return number if math.isfinite(number) else _refuse(f"{name}: the number {word[:40]} is too large")


def _make_object(pairs: list[tuple[str, Any]], name: str) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) < len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))
        raise JobError(f'{name}: the key "{twice[:60]}" stands twice in one object; keep one of them')
    return made
