import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from texts import overlapping_texts, texts_outside, unlabelled

from flycontrol.report import page_figures, style
from flycontrol.report.chain import loop_chain
from flycontrol.report.figures.chart import shows_second_pair
from flycontrol.report.page_figures import page_figures as draw
from flycontrol.units import ms

STABLE = {"bode", "nyquist", "budget", "gain-locus", "delay-locus", "chart", "recoveries", "strength", "damping"}
WITHOUT_STABILITY = {"bode", "nyquist", "gain-locus", "delay-locus", "chart", "damping"}


def matplotlib_figures(study, monkeypatch):
    """Every figure before it becomes SVG, by name."""
    caught = {}

    def keep(figure, name, _title):
        caught[name] = figure
        return ""

    monkeypatch.setattr(page_figures, "svg", keep)
    draw(study, loop_chain(study.result.loop, 220.0), 220.0)
    return caught


@pytest.fixture(params=["stable", "unstable"])
def figures(request, monkeypatch):
    return matplotlib_figures(request.getfixturevalue(request.param), monkeypatch)


def test_every_part_of_a_stable_study_is_drawn(stable, monkeypatch):
    assert set(matplotlib_figures(stable, monkeypatch)) == STABLE


def test_an_unstable_loop_is_drawn_without_margins_and_recovery(unstable, monkeypatch):
    assert set(matplotlib_figures(unstable, monkeypatch)) == WITHOUT_STABILITY


def test_every_axis_label_has_a_unit(figures):
    for name, figure in figures.items():
        assert not unlabelled(figure), name
        assert any(ax.get_xlabel() for ax in figure.axes), name
        assert any(ax.get_ylabel() for ax in figure.axes) or name == "budget"


def test_no_text_leaves_its_figure_or_overlaps_another(figures):
    for name, figure in figures.items():
        assert not texts_outside(figure), name
        assert not overlapping_texts(figure), name


def test_colours_that_share_a_panel_differ_in_greyscale():
    def lightness(colour):
        return float(np.dot(to_rgb(colour), (0.2126, 0.7152, 0.0722)))

    for a, b in combinations((style.EXACT, style.PADE, style.MARK), 2):
        assert abs(lightness(a) - lightness(b)) > 0.08
    steps = np.diff([lightness(colour) for colour in style.STRENGTHS])
    assert (steps < -0.08).all()


def test_exact_and_pade_lines_differ_without_colour():
    assert style.PADE_LINE.get("linestyle") != style.EXACT_LINE.get("linestyle", "-")


def test_svg_rounds_coordinates_and_never_words(stable, monkeypatch):
    figure = matplotlib_figures(stable, monkeypatch)["nyquist"]
    monkeypatch.undo()
    text = style.svg(figure, "n", "title")
    assert "modulus margin 0.559" in text
    assert not re.search(r"<[^>]*\d\.\d{3,}[^>]*>", text)


def test_a_caption_states_the_numbers_of_its_study(stable):
    captions = {
        name: figure.caption for name, figure in draw(stable, loop_chain(stable.result.loop, 220.0), 220.0).items()
    }
    assert "2.58" in captions["bode"]
    assert "55.5°" in captions["bode"]
    assert "0.559" in captions["nyquist"]
    assert "35.3" in captions["delay-locus"]
    assert "41.9°" in captions["strength"]


def test_the_phase_budget_adds_up_to_the_phase_margin(stable):
    from flycontrol.report.figures.budget import budget

    margins = stable.result.margins
    chain = loop_chain(stable.result.loop, 220.0).chain
    total = sum(phase for _, phase in budget(chain, margins.gain_crossovers[-1]))
    assert np.radians(total + 180.0) == pytest.approx(margins.phase_margin, rel=1e-12)


@pytest.fixture(scope="module")
def swinging(parameters, studied):
    """A loop whose second swing leaves the band at a small peak, so that yaw comes back from the other side."""
    gains = {
        "proportional_gain": replace(parameters.proportional_gain, value=3500.0, text="3500 1/s^2"),
        "derivative_gain": replace(parameters.derivative_gain, value=50.0, text="50 1/s"),
    }
    return studied(replace(parameters, **gains))


def test_the_dot_at_the_end_of_a_recovery_lies_on_the_curve_of_yaw(swinging, stable, monkeypatch):
    sides = []
    for study in (swinging, stable):
        axes = matplotlib_figures(study, monkeypatch)["recoveries"].axes[0]
        end = study.result.recovery_time / ms
        dot = next(line for line in axes.lines if line.get_marker() == "o")
        curve = axes.lines[1 + 2 * int(np.argmin(np.abs(study.recoveries.peaks - study.result.task.peak)))]
        assert dot.get_xdata()[0] == end
        side = dot.get_ydata()[0]
        assert np.interp(end, *curve.get_data()) == pytest.approx(side, abs=0.02)  # straight between points
        sides.append(side)
    assert sides == [-2.0, 2.0]


def test_the_words_at_a_jump_stay_between_the_axes(swinging, monkeypatch):
    figure = matplotlib_figures(swinging, monkeypatch)["strength"]
    assert not overlapping_texts(figure)
    assert not texts_outside(figure)
    renderer, inside = figure.canvas.get_renderer(), figure.axes[0].get_window_extent()
    jumps = [text for text in figure.axes[0].texts if "leaves the band" in text.get_text()]
    assert jumps
    for text in jumps:
        box = text.get_window_extent(renderer)
        assert inside.x0 < box.x0
        assert box.x1 < inside.x1


def test_a_line_that_the_chart_does_not_show_is_not_spoken_of(stable):
    caption = draw(stable, loop_chain(stable.result.loop, 220.0), 220.0)["chart"].caption
    assert ("thin line" in caption) == shows_second_pair(stable.delay_slice)
    far = replace(stable.delay_slice, next_crossing=np.full_like(stable.delay_slice.next_crossing, 10.0))
    hidden = replace(stable, delay_slice=far)
    assert "thin line" not in draw(hidden, loop_chain(stable.result.loop, 220.0), 220.0)["chart"].caption
