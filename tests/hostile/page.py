"""The measured part of docs/hostile.md: counts and worsts by filter, by kind of mesh, and of everything broken."""

from collections import Counter, defaultdict

from hostile.jobs import FILTERS

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
REFUSALS = ("OptionError", "NoPathError", "CollapsedError")


def write(results, unfinished, path):
    """Writes the tables between the marks of the page; returns the broken ones as (mesh, record)."""
    broken = [(r["mesh"], record) for r in results for record in r["records"] if record["outcome"] == "BROKEN"]
    text = path.read_text(encoding="utf-8")
    head, tail = text.split(BEGIN)[0], text.split(END)[1]
    measured = "\n\n".join([_summary(results, broken, unfinished), _by_filter(results), _by_kind(results)])
    path.write_text(f"{head}{BEGIN}\n\n{measured}\n\n{END}{tail}", encoding="utf-8")
    return broken


def _summary(results, broken, unfinished):
    lines = sum(len(r["records"]) for r in results)
    shared = sum(r["kind"] == "shared" for r in results)
    return (
        f"{lines:,} lines were asked for, on {shared} shared and {len(results) - shared} made meshes of "
        f"{min(r['triangles'] for r in results)} to {max(r['triangles'] for r in results):,} triangles. "
        f"Broken promises: {len(broken)}. Hangs and crashes: {len(unfinished)}."
    )


def _by_filter(results):
    groups = defaultdict(list)
    for result in results:
        for record in result["records"]:
            groups[record["way"]].append((record, result))
    rows = [
        "| filter | asked | refused | lines | converged | at vertices | cycle | max_iterations | settled "
        "| worst rounds | worst time, s | on |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for way in FILTERS:
        pairs = groups[way]
        count = Counter(record["outcome"] for record, _ in pairs)
        refused = sum(count[name] for name in REFUSALS)
        made = len(pairs) - refused
        settled = count["converged"] + count["converged_at_vertices"]
        rounds = max(record["rounds"] for record, _ in pairs)
        slowest, where = max(pairs, key=lambda pair: pair[0]["ms"])
        rows.append(
            f"| {way} | {len(pairs):,} | {refused:,} | {made:,} | {count['converged']:,} "
            f"| {count['converged_at_vertices']:,} | {count['cycle']:,} | {count['max_iterations']:,} "
            f"| {_percent(settled, made)} | {rounds} | {slowest['ms'] / 1e3:.2f} "
            f"| {where['mesh']}, {slowest['kind']} picks |"
        )
    return "\n".join(rows)


def _by_kind(results):
    groups = defaultdict(list)
    for result in results:
        groups[result["kind"]].append(result)
    rows = [
        "| meshes | number | triangles | lines | OptionError | NoPathError | CollapsedError "
        "| geodesic and fair settled | linear settled | cubic 1e-2 settled | worst rounds | worst time, s |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for kind, group in groups.items():
        records = [record for result in group for record in result["records"]]
        count = Counter(record["outcome"] for record in records)
        sizes = [result["triangles"] for result in group]
        rows.append(
            f"| {kind} | {len(group)} | {min(sizes)} to {max(sizes):,} | {len(records):,} "
            + "".join(f"| {count[name]:,} " for name in REFUSALS)
            + "".join(
                f"| {_settled(records, ways)} "
                for ways in (("geodesic", "fair", "fair inf"), ("linear",), ("cubic 1e-2",))
            )
            + f"| {max(r['rounds'] for r in records)} | {max(r['ms'] for r in records) / 1e3:.2f} |"
        )
    return "\n".join(rows)


def _settled(records, ways):
    made = [r for r in records if r["way"] in ways and r["outcome"] not in REFUSALS]
    return _percent(sum(r["outcome"].startswith("converged") for r in made), len(made))


def _percent(part, whole):
    if whole == 0:
        return "-"
    # Never rounded up to a hundred.
    return "100 %" if part == whole else f"{min(100 * part / whole, 99.99):.2f} %"
