from importlib.resources import files

import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.model.parameters import Sourced
from flycontrol.model.references import cite, references


def test_a_key_gives_the_paper_as_printed():
    paper = cite("ristroph2010")
    assert paper.label == "Ristroph et al. 2010"
    assert str(paper).endswith("by inducing aerial stumbles. PNAS 107:4820–4824.")


def test_an_unknown_key_is_refused_and_the_nearest_is_suggested():
    with pytest.raises(InvalidParameterError, match=r"'ristrop2010' is no reference .* the nearest is 'ristroph2010'"):
        cite("ristrop2010")
    with pytest.raises(InvalidParameterError, match="known keys: review"):
        cite("")


def test_every_entry_of_the_bibliography_is_read():
    text = files("flycontrol.model").joinpath("references.bib").read_text(encoding="utf-8")
    entries = text.count("\n@") + text.startswith("@") - text.count("@comment")
    assert len(references()) == entries
    for reference in references().values():
        assert reference.title or reference.note, reference.key


def test_a_number_with_an_unknown_source_is_refused():
    with pytest.raises(InvalidParameterError, match="no reference"):
        Sourced(value=1.0, unit="s", source="nobody1900")


def test_a_number_of_unknown_certainty_is_refused():
    with pytest.raises(InvalidParameterError, match="Certainty must be one of S, S2, C, user"):
        Sourced(value=1.0, unit="s", certainty="sure")
