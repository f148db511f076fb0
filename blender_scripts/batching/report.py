"""The report of a run: one line of JSON for each line on each object, or for a file without any, and a summary.

Made from what the journals and results say, in the order of the plan; it holds no times: equal runs give equal reports.
"""

from collections import Counter
from pathlib import Path
from typing import Any

from .plan import WHOLE, Item, Shard
from .store import dump_json, write_whole


def name_report(shard: Shard) -> str:
    """File name of the report of a shard."""
    return "report.jsonl" if shard == WHOLE else f"report-{shard.number}-of-{shard.count}.jsonl"


def collect_entries(items: list[Item], notes: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """All entries in order; a file that has none is `missing`."""
    entries = []
    for item in items:
        note = notes.get(item.result)
        if note is None:
            entries.append({"file": item.name, "object": None, "line": None, "status": "missing"})
        else:
            entries.extend(note["entries"])
    return entries


def write_report(output: Path, shard: Shard, entries: list[dict[str, Any]]) -> Path:
    """Write the report; its path."""
    path = output / name_report(shard)
    write_whole(path, b"".join(map(dump_json, entries)))
    return path


def make_summary(items: list[Item], notes: dict[str, dict[str, Any]]) -> list[str]:
    """The table that is printed at the end."""
    entries = collect_entries(items, notes)
    states = Counter(judge_file(notes.get(item.result)) for item in items)
    errors = Counter(entry["error"] for entry in entries if entry["status"] == "failed")
    lines = Counter(entry["status"] for entry in entries if entry["line"] is not None)
    table = [
        f"{'files':<24}{len(items):>8}",
        f"{'  done':<24}{states['done']:>8}",
        f"{'  done in part':<24}{states['part']:>8}",
        f"{'  failed':<24}{states['failed']:>8}",
        f"{'  missing':<24}{states['missing']:>8}",
        f"{'lines done':<24}{lines['done']:>8}",
    ]
    table += [f"{'  ' + name:<24}{count:>8}" for name, count in sorted(errors.items(), key=lambda e: (-e[1], e[0]))]
    return table


def judge_file(note: dict[str, Any] | None) -> str:
    """One word for what became of a file."""
    if note is None:
        return "missing"
    failed = any(entry["status"] == "failed" for entry in note["entries"])
    return ("part" if note["saved"] else "failed") if failed else "done"


def sum_seconds(notes: list[dict[str, Any]]) -> dict[str, float]:
    """Where the time of these files went, added up over all workers."""
    total: Counter[str] = Counter()
    for note in notes:
        total.update(note.get("seconds", {}))
    return dict(total)
