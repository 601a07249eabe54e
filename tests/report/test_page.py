import re
from dataclasses import replace

import pytest
from outline import Outline

from flycontrol.errors import OutputError
from flycontrol.report import page as page_module
from flycontrol.report.page import page, write_report
from flycontrol.report.provenance import provenance


@pytest.fixture(scope="module")
def stable_page(stable, parameters, origin):
    return page(stable, parameters, origin)


@pytest.fixture(scope="module")
def unstable_page(unstable, unstable_parameters, origin):
    return page(unstable, unstable_parameters, origin)


@pytest.fixture(params=["stable_page", "unstable_page"])
def any_page(request):
    return request.getfixturevalue(request.param)


def test_the_page_fetches_nothing_and_runs_nothing(any_page):
    outline = Outline(any_page)
    assert not {"script", "link", "img", "iframe", "object", "image"} & set(outline.tags)
    assert all(target.startswith("#") for target in outline.targets)
    assert "@import" not in any_page
    assert all(url.startswith("#") for url in re.findall(r"url\(([^)]*)\)", any_page))
    assert "http" not in any_page


def test_the_table_of_poles_says_whether_a_count_certifies_it(stable, stable_page, parameters, origin):
    assert "Certified: a count by the argument principle" in stable_page
    doubted = replace(stable, result=replace(stable.result, poles_status="not certified"))
    assert "does not confirm that none is missing: not certified" in page(doubted, parameters, origin)


def test_symbols_of_the_gains_are_never_raw(any_page):
    assert "K_P" not in any_page
    assert "K_D" not in any_page


def test_every_element_is_closed(any_page):
    outline = Outline(any_page)
    assert not outline.errors
    assert not outline.open


def test_ids_are_unique_and_every_link_leads_somewhere(any_page):
    outline = Outline(any_page)
    assert len(outline.ids) == len(set(outline.ids))
    used = [target[1:] for target in outline.targets] + re.findall(r"url\(#([^)]*)\)", any_page)
    assert set(used) <= set(outline.ids)


def test_figures_and_tables_are_numbered_in_order(any_page):
    for kind in ("Figure", "Table"):
        numbers = [int(n) for n in re.findall(rf"(?:<b>|<caption>){kind} (\d+)\.", any_page)]
        assert numbers == list(range(1, len(numbers) + 1))
        assert numbers


def test_the_page_stays_below_one_and_a_half_megabytes(any_page):
    assert len(any_page.encode()) < 1.5e6


def test_rendering_twice_gives_the_same_bytes(stable, parameters, origin, stable_page):
    assert page(stable, parameters, origin) == stable_page


@pytest.mark.slow
def test_two_processes_write_the_same_bytes(fresh_reports):
    for name in ("index.html", "result.json"):
        first, second = ((folder / name).read_bytes() for folder in fresh_reports)
        assert first == second


def test_a_hostile_name_is_shown_and_never_markup(stable, parameters):
    hostile = '<script>alert("&1")</script>'
    written = page(stable, replace(parameters, name=hostile), provenance(parameters, f"run {hostile}", None))
    assert "<script" not in written
    assert Outline(written).text.count(hostile) >= 4  # title, heading, verdict, command


def test_every_parameter_stands_with_its_value_source_and_certainty(stable_page, parameters):
    rows = re.findall(r"<tr>.*?</tr>", stable_page)
    for number in parameters.sourced().values():
        shown = number.text.split(" ")[0].partition("e-")[0]
        assert any(
            f"#ref-{number.source}" in row and f"<td>{number.certainty}</td>" in row and shown in row for row in rows
        )


def test_a_parameter_without_a_source_is_called_the_users(stable, parameters, origin):
    own = replace(parameters, delay=replace(parameters.delay, source="", certainty="user", text="14 ms"))
    row = next(row for row in re.findall(r"<tr>.*?</tr>", page(stable, own, origin)) if "14 ms" in row)
    assert "<td>user</td>" in row
    assert "#ref-" not in row


def test_the_verdict_of_a_stable_loop_comes_first_with_its_numbers(stable_page):
    text = Outline(stable_page).text.replace("\N{NO-BREAK SPACE}", " ")
    first = text[: text.index("The model\n")]
    for number in ("2.58", "55.5°", "21.7 ms", "0.559", "56.4 ms", "12.4 wingbeats", "189"):
        assert number in first


def test_an_unstable_loop_gets_a_whole_page_that_says_so(unstable_page):
    outline = Outline(unstable_page)
    assert "Verdict: unstable" in outline.text
    assert "margins and a recovery time do not exist" in outline.text
    assert {
        "figure-bode",
        "figure-nyquist",
        "figure-gain-locus",
        "figure-delay-locus",
        "figure-chart",
        "figure-damping",
    } <= set(outline.ids)
    assert not {"figure-recoveries", "figure-strength", "figure-budget"} & set(outline.ids)
    assert not re.search(r"\b(nan|inf|None)\b", outline.text)


def test_nothing_is_left_behind_when_the_folder_cannot_be_made(stable, parameters, tmp_path, monkeypatch):
    monkeypatch.setattr(page_module, "study", lambda *_, **__: stable)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError):
        write_report(parameters, None, tmp_path / "file" / "out", command="flycontrol report")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_page_and_numbers_are_written_together(stable, parameters, tmp_path, monkeypatch):
    monkeypatch.setattr(page_module, "study", lambda *_, **__: stable)
    write_report(parameters, None, tmp_path / "new", command="flycontrol report")
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["index.html", "result.json"]
