"""What analyses state is read as it stands, in a closed vocabulary."""

import json

import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.io.analyses import read_analyses
from flycontrol.io.claims import read_claims

CLAIM = {"claim": "wings paddle", "published": "0.6", "ours": "0.5", "agreement": "roughly: 17 % off"}


def written(folder, found):
    path = folder / "note.json"
    path.write_text(found if isinstance(found, str) else json.dumps(found))
    return path


def test_claims_come_as_they_stand_with_the_verdict_that_they_begin_with(tmp_path):
    entries = [
        CLAIM | {"agreement": f"{verdict}{rest}"}
        for verdict in ("agrees", "roughly", "fails", "cannot be told", "shown here")
        for rest in ("", ", if the axis is there", ": by far")
    ]
    claims = read_claims(written(tmp_path, {"claims": entries, "other": 1}))
    assert [claim.agreement for claim in claims] == [entry["agreement"] for entry in entries]
    assert all(claim.agreement.startswith(claim.verdict) for claim in claims)
    assert {claim.where for claim in claims} == {""}


@pytest.mark.parametrize("found", [{"numbers": 1}, [1, 2], 3])
def test_an_analysis_may_state_no_claims(tmp_path, found):
    assert read_claims(written(tmp_path, found)) is None
    assert read_claims(tmp_path / "none.json") is None


@pytest.mark.parametrize(
    ("found", "sentence"),
    [
        ("{", "note.json is not valid JSON"),
        ({"claims": 3}, "claims must be a list, got 3"),
        ({"claims": ["agrees"]}, 'claim 1 must be an object of texts, got "agrees"'),
        ({"claims": [CLAIM, CLAIM | {"ours": 0.5}]}, "claim 2: ours must be a text, got 0.5; write it in quotes"),
        ({"claims": [CLAIM | {"ours": " "}]}, "claim 1 lacks ours"),
        ({"claims": [{"claim": "wings paddle"}]}, "claim 1 lacks published"),
        ({"claims": [CLAIM | {"mood": "good"}]}, "unknown field mood"),
        ({"claims": [CLAIM | {"agreement": "it agrees"}]}, "begins with one of agrees, roughly, fails"),
        ({"claims": [CLAIM | {"agreement": "agreeable"}]}, "begins with one of"),
        ({"claims": [CLAIM | {"basis": "hearsay"}]}, "basis is one of simulated, real data"),
    ],
)
def test_claims_that_say_something_else_are_refused_in_a_sentence(tmp_path, found, sentence):
    with pytest.raises(InvalidInputError, match=sentence):
        read_claims(written(tmp_path, found))


def test_a_folder_of_analyses_is_read_with_questions_neighbours_and_order(tmp_path):
    (tmp_path / "b.py").write_text('"""Is it b?\n\nYes.\n"""\nfrom c import x\nimport json\n')
    (tmp_path / "c.py").write_text("import d.e\n")
    (tmp_path / "d.py").write_text("import b\n")
    (tmp_path / "_own.py").write_text("")
    (tmp_path / "validation.toml").write_text('data = "measured"\nfirst = ["d"]\n[left_out]\nc = "too long"\n')
    found = read_analyses(tmp_path)
    assert [(a.name, a.question) for a in found.analyses] == [("d", "d"), ("b", "Is it b?")]
    assert {tuple(path.name for path in a.sources) for a in found.analyses} == {("b.py", "c.py", "d.py")}
    assert found.left_out == {"c": "too long"}
    assert found.data == tmp_path / "measured"


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        ({}, "holds no analysis"),
        ({"a.py": "1", "validation.toml": 'first = ["b"]'}, "names b, but .* holds no b.py"),
        (
            {"a.py": "1", "validation.toml": 'first = ["c", "a"]\n[left_out]\nb = "long"\nc = "long"'},
            "names c, b, but .* holds no Python files of these 2 names; put them there",
        ),
        ({"a.py": "1", "validation.toml": 'last = ["a"]'}, "last is not a key known here"),
        ({"a.py": "1", "validation.toml": "first = [1]"}, "first.0 is 1"),
    ],
)
def test_a_folder_that_is_none_of_analyses_is_refused_in_a_sentence(tmp_path, files, sentence):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(InvalidInputError, match=sentence):
        read_analyses(tmp_path)
    with pytest.raises(InvalidInputError, match="no such folder of analyses"):
        read_analyses(tmp_path / "elsewhere")
