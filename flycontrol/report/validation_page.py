"""The page of a validation: each claim of the review a row, by section, those that fail too."""

from __future__ import annotations

import re
from pathlib import Path

from markupsafe import Markup, escape

from flycontrol.jobs.files import write_files_atomically
from flycontrol.report.page import template_environment, the_css
from flycontrol.report.validation import BESIDE, SECTIONS, Validation, summary, tally
from flycontrol.report.validation_provenance import ValidationProvenance, validation_provenance
from flycontrol.report.validation_result import validation_result_json

_ITALIC = re.compile(r"(?<!\w)\*([^*\s][^*]*)\*(?!\w)")
_CODE = re.compile(r"`([^`]+)`")
_POWER = re.compile(r"\^(-?\d+)")


def write_validation_report(validation: Validation, folder: Path, *, command: str) -> tuple[Path, ...]:
    """Write index.html and result.json, both or none; OutputError if they cannot be written."""
    origin = validation_provenance(command)
    files = {
        "index.html": validation_page(validation, origin),
        "result.json": validation_result_json(validation, origin),
    }
    return write_files_atomically(folder, files)


def validation_page(validation: Validation, origin: ValidationProvenance) -> str:
    """Render the page, self-contained but for links to the analyses' own reports."""
    environment = template_environment()
    environment.filters["marked"] = marked
    sections = validation.by_section()
    return environment.get_template("validation.html").render(
        css=the_css(environment),
        origin=origin,
        validation=validation,
        summary=summary(validation),
        sections=[(number, _title(number), rows, tally(rows)) for number, rows in sections.items()],
        total=tally(validation.rows),
        tables={number: k for k, number in enumerate(sections, start=2)},
    )


def marked(text: str) -> Markup:
    """Text of a note as HTML: *italics*, `code` and powers, all else as it is."""
    found = _CODE.sub(r"<code>\1</code>", _ITALIC.sub(r"<em>\1</em>", str(escape(text))))
    return Markup(_POWER.sub(r"<sup>\1</sup>", found))


def _title(number: int) -> str:
    return "Beside the review" if number == BESIDE else f"Section {number}: {SECTIONS[number]}"
