"""The page of claims: well-formed, every row with its analysis, failures among them."""

import re
from dataclasses import replace

import pytest
from outline import Outline, leaves, read_json

from flycontrol.io.claims import Claim
from flycontrol.report.validation import Finding, Validation, section_of, summary, tally
from flycontrol.report.validation_page import marked, validation_page
from flycontrol.report.validation_provenance import validation_provenance
from flycontrol.report.validation_result import FIELDS, validation_result_json

ORIGIN = validation_provenance("flycontrol validate")


def claim(agreement, **changes):
    said = {"claim": "<wings> paddle", "published": "0.6", "ours": "0.5 of *D. hydei*", "where": "section 5, Fig. 6d"}
    return Claim(**said | {"agreement": agreement} | changes)


@pytest.fixture
def validation():
    hinge = (claim("agrees"), claim("fails: by *far*"), claim("shown here", where="", published="not claimed"))
    turn = (claim("roughly", where="Fig. 4c", basis="real data"), claim("agrees", where="", published="Eq. 6"))
    return Validation(
        findings=(
            Finding(name="a_hinge", question="Spring?", claims=hinge, links={"note": "a/a.md", "numbers": "a/a.json"}),
            Finding(name="b_turn", question="A turn?", claims=turn, links={"figure": "b/b.svg"}),
            Finding(name="c_lost", question="Lost?", claims=(), links={}, failure="no <data>"),
        ),
        left_out={"d_long": "ten minutes"},
        data=("flights",),
        data_sha256="00ff",
    )  # fmt: skip


def test_the_page_is_well_formed_and_every_row_leads_to_its_analysis(validation):
    page = validation_page(validation, ORIGIN)
    outline = Outline(page)
    assert not outline.errors
    assert not outline.open
    assert len(outline.ids) == len(set(outline.ids))
    rows = re.findall(r"<tr><th scope=\"row\">.*?</tr>", page)
    claims = [row for row in rows if 'class="verdict' in row]
    assert len(claims) == 5
    assert sum('<a href="a/a.md">a hinge</a>' in row for row in claims) == 3
    assert sum('<a href="b/b.svg">b turn</a>' in row for row in claims) == 2
    assert all(target.startswith("#") and target[1:] in outline.ids for target in outline.targets if "#" in target)


def test_what_fails_and_what_could_not_be_run_stands_there_too(validation):
    page = validation_page(validation, ORIGIN)
    assert "<b>fails</b>: by <em>far</em>" in page
    assert "<b>no result:</b> no &lt;data&gt;" in page
    assert "d long (ten minutes)" in page
    assert "&lt;wings&gt; paddle" in page


def test_the_summary_counts_every_claim_once(validation):
    assert tally(validation.rows) == {"agrees": 2, "roughly": 1, "fails": 1, "cannot be told": 0, "shown here": 1}
    assert summary(validation).startswith("Of 4 claims")
    assert summary(validation).endswith("1 of 3 analyses gave no result: c_lost.")
    assert sum(len(rows) for rows in validation.by_section().values()) == len(validation.rows)


def test_the_summary_says_how_many_agreements_rest_on_measurements(validation):
    assert "(" not in summary(validation)  # no analysis says
    bases = ("simulated and real data", "real data", "simulated")
    told = replace(validation.findings[0], claims=tuple(claim("agrees", basis=basis) for basis in bases))
    assert "(2 on real data, 1 in simulation alone)" in summary(replace(validation, findings=(told,)))


def test_without_measurements_the_page_says_so(validation):
    page = validation_page(replace(validation, data=(), data_sha256=""), ORIGIN)
    assert "Real measurements were not there" in page
    assert "Real measurements were not there" not in validation_page(validation, ORIGIN)


@pytest.mark.parametrize(
    ("where", "published", "section"),
    [
        ("section 4, Fig. 6a", "", 4), ("Fig. 8c", "section 2", 6), ("", "Eq. 7", 7), ("", "sections 3 and 4", 3),
        ("Figs. 3a and 4", "", 3), ("Fig. 9", "0.6 (text)", 0), ("", "21 to 54", 0), ("Eqs. 3 to 5", "", 4),
    ],
)  # fmt: skip
def test_a_claim_stands_in_the_section_of_its_words_its_figure_or_its_equation(where, published, section):
    assert section_of(claim("agrees", where=where, published=published)) == section


def test_every_field_of_the_result_is_explained(validation):
    found = read_json(validation_result_json(validation, ORIGIN))
    assert found["fields"] == FIELDS
    assert [row["analysis"] for row in found["claims"]] == ["b_turn", "a_hinge", "a_hinge", "b_turn", "a_hinge"]
    known = set(leaves({key: value for key, value in found.items() if key != "fields"}))
    for path in known:
        assert any(re.fullmatch(_pattern(field), path) for field in FIELDS), path


def _pattern(field):
    return re.escape(field).replace(r"\*", "[^.]+") + (r"(\..*)?" if field == "provenance" else "")


def test_notes_write_italics_code_and_powers():
    shown = marked("10^-12 of *D. hydei* < 3*4*5 by `fit`")
    assert shown == "10<sup>-12</sup> of <em>D. hydei</em> &lt; 3*4*5 by <code>fit</code>"
