"""The claims of the review beside what the analyses find: rows by section, and how many agree."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import get_args

from flycontrol.io.claims import Claim, Verdict
from flycontrol.report.numbers import counted

#: Sections of the review with claims, and their figures.
SECTIONS = {
    1: "Introduction",
    2: "Experimental methods, Figs. 1 and 2",
    3: "Simulation methods, Fig. 3",
    4: "Maneuvering dynamics, Figs. 4 and 5",
    5: "Wing actuation and dynamics, Fig. 6",
    6: "Auto-stabilization and sensory-neural control, Figs. 7 and 8",
    7: "Synthesis and implications",
}
BESIDE = 0  #: number of what stands in no section
_OF_FIGURE = {1: 2, 2: 2, 3: 3, 4: 4, 5: 4, 6: 5, 7: 6, 8: 6}
_OF_EQUATION = {1: 4, 2: 4, 3: 4, 4: 4, 5: 4, 6: 6, 7: 7, 8: 7}
_VERBS: dict[Verdict, tuple[str, str]] = {
    "agrees": ("agrees", "agree"), "roughly": ("agrees roughly", "agree roughly"), "fails": ("fails", "fail"),
}  # fmt: skip
_PLACES = (
    (re.compile(r"sections? (\d)"), {number: number for number in SECTIONS}),
    (re.compile(r"Figs?\. ?(\d)"), _OF_FIGURE),
    (re.compile(r"Eqs?\. ?(\d)"), _OF_EQUATION),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One analysis and what it states."""

    name: str
    question: str
    claims: tuple[Claim, ...]  #: none if it states none
    links: dict[str, str]  #: to what it wrote, by kind: note, figure, numbers
    failure: str = ""  #: why it could not be run or read

    @property
    def link(self) -> str:
        """To what a reader wants first, empty if there is nothing."""
        return next((self.links[kind] for kind in ("note", "figure", "numbers") if kind in self.links), "")


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A claim, and whose."""

    claim: Claim
    finding: Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
    """All findings, and what they were made with."""

    findings: tuple[Finding, ...]
    left_out: dict[str, str]  #: why, by analysis
    data: tuple[str, ...]  #: names of the folders of real measurements; none if there were none
    data_sha256: str  #: over all their files; empty if there were none

    @property
    def failed(self) -> tuple[Finding, ...]:
        """Those that could not be run or read."""
        return tuple(finding for finding in self.findings if finding.failure)

    @property
    def rows(self) -> tuple[Row, ...]:
        """Every claim, by analysis."""
        return tuple(Row(claim=claim, finding=finding) for finding in self.findings for claim in finding.claims)

    def by_section(self) -> dict[int, tuple[Row, ...]]:
        """Rows by section of the review, those of no section last."""
        found = {number: tuple(row for row in self.rows if section_of(row.claim) == number) for number in SECTIONS}
        beside = tuple(row for row in self.rows if section_of(row.claim) == BESIDE)
        return {number: rows for number, rows in (found | {BESIDE: beside}).items() if rows}


def section_of(claim: Claim) -> int:
    """Section of the review in which a claim stands, by its words or else by figure or equation."""
    for text in (claim.where, claim.published):
        for pattern, sections in _PLACES:
            found = pattern.search(text)
            if found and int(found[1]) in sections:
                return sections[int(found[1])]
    return BESIDE


def tally(rows: tuple[Row, ...]) -> dict[Verdict, int]:
    """How many claims have each verdict."""
    counts = Counter(row.claim.verdict for row in rows)
    return {verdict: counts[verdict] for verdict in get_args(Verdict)}


def summary(validation: Validation) -> str:
    """Count agreement and failure in a sentence or two."""
    count = tally(validation.rows)
    judged = sum(count[verdict] for verdict in ("agrees", "roughly", "fails", "cannot be told"))
    agree, roughly, fail = (counted(count[verdict], *words) for verdict, words in _VERBS.items())
    sentence = (
        f"Of {judged} claims and numbers of the review and its sources, {agree} with what the package finds"
        f"{_on_what(validation.rows)}, {roughly} and {fail}"
    )
    sentence += f"; {count['cannot be told']} cannot be told." if count["cannot be told"] else "."
    if count["shown here"]:
        sentence += f" {counted(count['shown here'], 'more goes', 'more go')} beyond the review."
    if validation.failed:
        names = ", ".join(finding.name for finding in validation.failed)
        sentence += f" {len(validation.failed)} of {len(validation.findings)} analyses gave no result: {names}."
    return sentence


def _on_what(rows: tuple[Row, ...]) -> str:
    """How many of those that agree rest on measurements: a simulation that agrees is no observation."""
    bases = [row.claim.basis for row in rows if row.claim.verdict == "agrees" and row.claim.basis]
    simulated = bases.count("simulated")
    return f" ({len(bases) - simulated} on real data, {simulated} in simulation alone)" if bases else ""
