import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from flycontrol.report import page_figures, style
from flycontrol.report.chain import loop_chain
from flycontrol.report.page_figures import page_figures as draw

STABLE = {"bode", "nyquist", "budget", "gain-locus", "delay-locus", "recoveries", "strength", "damping"}
WITHOUT_STABILITY = {"bode", "nyquist", "gain-locus", "delay-locus", "damping"}


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
        panels = figure.axes
        second = [child for ax in panels for child in ax.child_axes]
        labels = [label for ax in [*panels, *second] for label in (ax.get_xlabel(), ax.get_ylabel()) if label]
        assert all(re.search(r"\[[^\]]+\]$", label) for label in labels), name
        assert all(ax.get_xlabel() or ax.get_shared_x_axes().get_siblings(ax)[1:] for ax in panels), name
        assert any(ax.get_ylabel() for ax in panels) or name == "budget"


def test_no_text_leaves_its_figure_or_overlaps_another(figures):
    for name, figure in figures.items():
        boxes = [(text.get_text(), box) for text, box in drawn_texts(figure)]
        width, height = figure.bbox.width, figure.bbox.height
        for words, box in boxes:
            assert box.x0 > -1, (name, words)
            assert box.y0 > -1, (name, words)
            assert box.x1 < width + 1, (name, words)
            assert box.y1 < height + 1, (name, words)
        overlapping = [(a, b) for (a, p), (b, q) in combinations(boxes, 2) if p.overlaps(q)]
        assert not overlapping, name


def drawn_texts(figure):
    """Every text that is drawn and its box, a little shrunk: neighbouring tick labels may touch."""
    FigureCanvasAgg(figure).draw()
    renderer = figure.canvas.get_renderer()
    for ax in [panel for main in figure.axes for panel in (main, *main.child_axes)]:
        legend = ax.get_legend()
        texts = [
            *ax.texts,
            ax.title,
            ax._left_title,
            ax.xaxis.label,
            ax.yaxis.label,
            *(legend.get_texts() if legend else []),
        ]
        for text in [*texts, *tick_labels(ax.xaxis), *tick_labels(ax.yaxis)]:
            if text.get_text().strip():
                yield text, Text.get_window_extent(text, renderer).shrunk(0.98, 0.9)


def tick_labels(axis):
    low, high = sorted(axis.get_view_interval())
    for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
        if low <= tick.get_loc() <= high:
            yield from (label for label in (tick.label1, tick.label2) if label.get_visible())


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
