"""Checks a value against the part of JSON Schema that the job's schema uses, and says what is wrong in plain words.

Blender's Python has no validator of its own, and a plain one would not guess what a misspelt key was meant to be.
Any validator reads the same schema; the tests compare the verdicts. Knows no jobs.
"""

import difflib
import json
from typing import Any

MOST_FAULTS = 20
TYPE_NAMES = {
    "object": "an object",
    "array": "a list",
    "string": "a text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
    "null": "null",
}


def list_faults(value: Any, schema: dict[str, Any]) -> list[str]:
    """One line for each fault of `value`, with its place; at most MOST_FAULTS, empty when all is well."""
    faults: list[str] = []
    _check(value, schema, schema, "", faults)
    if len(faults) > MOST_FAULTS:
        faults[MOST_FAULTS:] = [f"and {len(faults) - MOST_FAULTS} more"]
    return faults


def name_type(value: Any) -> str:
    """The JSON type of a value."""
    if isinstance(value, bool):
        return "boolean"
    for name, types in (("object", dict), ("array", list), ("string", str), ("integer", int), ("number", float)):
        if isinstance(value, types):
            return name
    return "null"


def show(value: Any) -> str:
    """A value as it stands in the job, shortened."""
    if isinstance(value, (dict, list)):
        return TYPE_NAMES[name_type(value)]
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "..."


def is_of_type(value: Any, wanted: str) -> bool:
    """Whether `value` is of the JSON type; as in the standard 2.0 is a whole number."""
    found = name_type(value)
    if wanted == "integer" and found == "number":
        return value.is_integer()
    return found == wanted or (wanted == "number" and found == "integer")


def _check(value: Any, schema: dict[str, Any], root: dict[str, Any], place: str, faults: list[str]) -> None:
    if "$ref" in schema:
        schema = _resolve(schema["$ref"], root)
    here = place or "the job"
    if "oneOf" in schema:
        _check_one_of(value, schema["oneOf"], root, place, faults)
        return
    if "type" in schema and not is_of_type(value, schema["type"]):
        faults.append(f"{here}: expected {TYPE_NAMES[schema['type']]}, found {show(value)}")
        return
    if "enum" in schema and value not in schema["enum"]:
        near = guess(value, schema["enum"])
        faults.append(f"{here}: {show(value)} is none of {', '.join(map(show, schema['enum']))}{near}")
        return
    kind = name_type(value)
    if kind in ("integer", "number"):
        _check_number(value, schema, here, faults)
    elif kind == "string" and len(value) < schema.get("minLength", 0):
        faults.append(f"{here}: the text is empty")
    elif kind == "array":
        _check_array(value, schema, root, place, faults)
    elif kind == "object":
        _check_object(value, schema, root, place, faults)


def _check_number(value: float, schema: dict[str, Any], here: str, faults: list[str]) -> None:
    if "minimum" in schema and value < schema["minimum"]:
        faults.append(f"{here}: {show(value)} is below the least, {schema['minimum']}")
    if "exclusiveMinimum" in schema and value <= schema["exclusiveMinimum"]:
        faults.append(f"{here}: {show(value)} must be above {schema['exclusiveMinimum']}")
    if "maximum" in schema and value > schema["maximum"]:
        faults.append(f"{here}: {show(value)} is above the most, {schema['maximum']}")


def _check_array(value: list[Any], schema: dict[str, Any], root: dict[str, Any], place: str, faults: list[str]) -> None:
    here, least, most = place or "the job", schema.get("minItems", 0), schema.get("maxItems")
    if len(value) < least or (most is not None and len(value) > most):
        wanted = str(least) if least == most else f"at least {least}" if most is None else f"{least} to {most}"
        faults.append(f"{here}: expected {wanted} {'entry' if wanted.endswith('1') else 'entries'}, found {len(value)}")
    if schema.get("uniqueItems") and len({json.dumps(item, sort_keys=True) for item in value}) < len(value):
        faults.append(f"{here}: an entry stands twice")
    if "items" in schema:
        for index, item in enumerate(value):
            _check(item, schema["items"], root, f"{place}[{index}]", faults)


def _check_object(
    value: dict[str, Any], schema: dict[str, Any], root: dict[str, Any], place: str, faults: list[str]
) -> None:
    properties, prefix = schema.get("properties", {}), f"{place}." if place else ""
    for key, inner in value.items():
        if key in properties:
            _check(inner, properties[key], root, prefix + key, faults)
        elif schema.get("additionalProperties", True) is False:
            faults.append(f"{prefix}{key[:60]}: unknown key{guess(key, properties) or known(properties)}")
    for key in schema.get("required", []):
        if key not in value:
            faults.append(f'{place or "the job"}: "{key}" is missing')


def _check_one_of(
    value: Any, branches: list[dict[str, Any]], root: dict[str, Any], place: str, faults: list[str]
) -> None:
    """The branches differ by their types or by a required key: the one that is meant says what is wrong."""
    resolved = [_resolve(branch["$ref"], root) if "$ref" in branch else branch for branch in branches]
    meant = [b for b in resolved if "type" not in b or is_of_type(value, b["type"])]
    if isinstance(value, dict) and len(meant) > 1:
        meant = [b for b in meant if b["required"][0] in value] or meant
        if len(meant) > 1:
            keys = [b["required"][0] for b in meant]
            both = [key for key in keys if key in value]
            if both:
                faults.append(f"{place}: has {' and '.join(both)}; keep one of them")
            else:
                near = next((text for key in value if (text := guess(key, keys))), "")
                faults.append(f"{place}: needs one of the keys {', '.join(keys)}{near}")
            return
    if not meant:
        names = dict.fromkeys(TYPE_NAMES[b["type"]] for b in resolved)
        faults.append(f"{place}: expected {' or '.join(names)}, found {show(value)}")
        return
    _check(value, meant[0], root, place, faults)


def _resolve(reference: str, root: dict[str, Any]) -> dict[str, Any]:
    found = root
    for part in reference.removeprefix("#/").split("/"):
        found = found[part]
    return found


def guess(word: Any, known_words: Any) -> str:
    """What a misspelt word was meant to be, as the end of a message; empty when nothing is near."""
    if not isinstance(word, str):
        return ""
    near = difflib.get_close_matches(word.lower(), [w for w in known_words if isinstance(w, str)], n=1, cutoff=0.6)
    return f'; did you mean "{near[0]}"?' if near else ""


def known(properties: dict[str, Any]) -> str:
    """What keys there are, as the end of a message."""
    return f"; known here: {', '.join(properties)}"
