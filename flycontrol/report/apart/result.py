"""What flies that are not pooled write for machines: result.json, estimates.csv, and a table to paste in a paper."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from flycontrol.identify.gains.apart import ApartStudy
from flycontrol.report.apart.tables import estimate_rows as rows_of_members
from flycontrol.report.apart.tables import heads, kinds_of
from flycontrol.report.fit.result import FitProvenance, estimates_csv, fit_result
from flycontrol.report.fit.surroundings import group_fields
from flycontrol.report.fit.tables import effect_rows
from flycontrol.report.fit.words import plain
from flycontrol.report.result import finite

#: What each field holds; those of one member are documented in its own `fields`.
FIELDS = {
    "status": "why the flies stand apart, and how many fits are usable",
    "by": "fly, or recording",
    "level": "of all intervals",
    "means": "flies beside each other, as `flies` of a pooled fit: sentences, fits, mean and spread of each unknown",
    "members[].name": "of the fly, or the recording",
    "members[].folder": "where its own report lies",
    "members[].result": "the whole result.json of its own fit",
    "provenance": "command, mapping, versions, seed",
}
_FIRST = "member"  #: column of estimates.csv before those of a pooled fit


def apart_result_json(study: ApartStudy, origin: FitProvenance) -> str:
    """Write everything as JSON, keys sorted, floats at full precision; what is not finite is null."""
    found: dict[str, Any] = {
        "fields": FIELDS,
        "status": study.status,
        "by": study.by,
        "level": study.level,
        "means": group_fields(study.group),
        "members": [
            {"name": member.name, "folder": member.folder, "result": fit_result(member.study, origin)}
            for member in study.members
        ],
        "provenance": asdict(origin),
    }
    return json.dumps(finite(found), indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def apart_estimates_csv(study: ApartStudy) -> str:
    """One row an estimate of every member, its name first, then the columns of a pooled fit."""
    lines: list[str] = []
    for member in study.members:
        head, *rows = estimates_csv(member.study).splitlines()
        lines = lines or [f"{_FIRST},{head}"]
        lines += [f"{_quoted(member.name)},{row}" for row in rows]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\n\r') else text


def apart_table(study: ApartStudy) -> str:
    """A table to paste in a paper, in Markdown: estimates of every member, then mean and spread."""
    names = [f"{plain(symbol)} [{unit}]" for symbol, unit in heads(study)]
    level = f"{100 * study.level:g} %"
    lines = [
        f"| {study.by} | recordings | {' | '.join(names)} | fit |",
        "|---" * (len(names) + 3) + "|",
        *(f"| {row.head} | {' | '.join(row.cells)} |" for _, row in rows_of_members(study)),
    ]
    effects = {e.kind: row.cells for e, row in zip(study.effects, effect_rows(study.group), strict=True)}
    if effects:
        means = [f"{effects[k][0]} ({effects[k][1]})" if k in effects else "" for k in kinds_of(study)]
        spreads = [f"{effects[k][2]} ({effects[k][3]})" if k in effects else "" for k in kinds_of(study)]
        lines += [
            f"| mean | | {' | '.join(means)} | |",
            f"| standard deviation between {study.plural} | | {' | '.join(spreads)} | |",
        ]
    controller = study.members[0].study.result.controller
    foot = (
        f"{controller} control of the yaw angle, restoring gains positive; estimates with {level} intervals. Status: "
        f"{study.status}"
    )
    return "\n".join([*lines, "", foot]) + "\n"
