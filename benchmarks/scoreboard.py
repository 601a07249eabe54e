"""Rows of the table: which setting of a tool counts, and how it stands against flycontrol."""

from dataclasses import asdict, dataclass

LEVELS = {
    "deg": (1e-1, 1e-3, 1e-6, 1e-9), "relative": (1e-6, 1e-10), "wrong verdicts": (0,), "wrong voxels": (0,),
    "standard errors": (1e-1, 1e-2, 1e-3), "apart": (1e-1, 1e-6),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One tool at one setting on one job, or the reason why there is none."""

    job: str
    tool: str
    use: str = ""
    setting: str = ""
    setup_s: float | None = None  #: what precedes the first run and can be kept: compiling, building the loop
    run_s: float | None = None  #: median
    best_s: float | None = None  #: least: less shaken by other load on the machine than the median
    cpu_s: float | None = None
    error: float | None = None
    unit: str = ""
    ratio: float | None = None  #: median over flycontrol's median
    ratio_of_best: float | None = None
    not_run: str | None = None


def chosen(measured, unit):
    """Of each use, the fastest setting within each level of error; the most accurate one if it reaches no level."""
    picks = []
    for use in dict.fromkeys(m["use"] for m in measured):
        group = [m for m in measured if m["use"] == use and m["error"] is not None]
        within = [[m for m in group if m["error"] <= level] for level in LEVELS[unit]]
        fastest = [min(some, key=lambda m: m["best_s"]) for some in within if some]
        fastest = fastest or ([min(group, key=lambda m: m["error"])] if group else [])
        picks += [m for i, m in enumerate(fastest) if m not in fastest[:i]]
    return picks


def against(ours, tool, measured):
    """Rows of a peer, with its times as multiples of flycontrol's."""
    for m in chosen(measured, ours.unit):
        yield Row(
            job=ours.job, tool=tool, use=m["use"], setting=m["setting"], setup_s=m["setup_s"], run_s=m["run_s"],
            best_s=m["best_s"], error=m["error"], unit=ours.unit,
            ratio=m["run_s"] / ours.run_s, ratio_of_best=m["best_s"] / ours.best_s,
        )  # fmt: skip


def as_json(rows):
    return [{name: value for name, value in asdict(row).items() if value not in (None, "")} for row in rows]


def as_markdown(rows):
    head = ["job", "tool", "setting", "setup", "median", "least", "error", "times flycontrol (median, least)"]
    lines = [head, ["---"] * len(head), *[_cells(row) for row in rows]]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    return "".join(
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |\n"
        for line in lines
    )


def _cells(row):
    if row.not_run:
        return [row.job, row.tool, f"not run: {row.not_run}", "", "", "", "", ""]
    setting = ": ".join(part for part in (row.use, row.setting) if part)
    cpu = f" (CPU {_time(row.cpu_s)})" if row.cpu_s is not None else ""
    error = f"{row.error:.2g} {row.unit}" if row.error is not None else ""
    ratio = f"{row.ratio:.3g}, {row.ratio_of_best:.3g}" if row.ratio else ""
    return [row.job, row.tool, setting, _time(row.setup_s), _time(row.run_s) + cpu, _time(row.best_s), error, ratio]


def _time(seconds):
    if not seconds:
        return ""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{seconds * 1e3:.3g} ms"
