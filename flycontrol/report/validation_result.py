"""result.json of a validation: every row of the page for machines."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from flycontrol.report.validation import Row, Validation, section_of, summary, tally
from flycontrol.report.validation_provenance import ValidationProvenance

#: What each field holds.
FIELDS = {
    "summary": "how many claims agree, in words",
    "counts.*": "claims by verdict: agrees, roughly, fails, cannot be told, shown here (the review does not say it)",
    "claims[].claim": "what the review or a source of it says",
    "claims[].published": "its number, or where it stands",
    "claims[].ours": "our number, with its unit",
    "claims[].agreement": "in words, beginning with the verdict",
    "claims[].verdict": "agrees, roughly, fails, cannot be told or shown here",
    "claims[].where": "place in the review; empty if only `published` says it",
    "claims[].basis": "simulated, real data, simulated and real data; empty if the analysis does not say",
    "claims[].section": "section of the review; 0 for what stands in none",
    "claims[].analysis": "that states it",
    "claims[].link": "to its report, relative to this file",
    "analyses[].name": "of the file",
    "analyses[].question": "that it asks",
    "analyses[].claims": "how many it states",
    "analyses[].failure": "why it could not be run or read; empty if it could",
    "analyses[].links.*": "note, figure and numbers, relative to this file",
    "left_out.*": "analyses that were not run, and why",
    "data.folders[]": "of real measurements that were there",
    "data.sha256": "over names and bytes of their files; null if there were none",
    "provenance": "command and versions",
}


def validation_result_json(validation: Validation, origin: ValidationProvenance) -> str:
    """Write everything as JSON, keys sorted."""
    found: dict[str, Any] = {
        "fields": FIELDS,
        "summary": summary(validation),
        "counts": tally(validation.rows),
        "claims": [_row(row) for rows in validation.by_section().values() for row in rows],
        "analyses": [
            {"name": f.name, "question": f.question, "claims": len(f.claims), "failure": f.failure, "links": f.links}
            for f in validation.findings
        ],
        "left_out": validation.left_out,
        "data": {"folders": validation.data, "sha256": validation.data_sha256 or None},
        "provenance": asdict(origin),
    }
    return json.dumps(found, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def _row(row: Row) -> dict[str, Any]:
    return asdict(row.claim) | {
        "verdict": row.claim.verdict,
        "section": section_of(row.claim),
        "analysis": row.finding.name,
        "link": row.finding.link,
    }
