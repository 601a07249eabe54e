"""Pictures hold what the results hold."""

import pickle

import control
import matplotlib as mpl
import numpy as np
import pytest
import scipy.ndimage
from matplotlib.patches import Circle

mpl.use("Agg")

import matplotlib.pyplot as plt

from flycontrol.delay import (
    Axis,
    StabilityChart,
    bode_plot,
    delay,
    feedback,
    frequency_response,
    gangof4,
    gangof4_plot,
    impulse_response,
    initial_response,
    margins,
    nichols_plot,
    nyquist_plot,
    nyquist_response,
    pade,
    pd_boundary,
    pole_map,
    pole_plot,
    response,
    rightmost_roots,
    root_locus,
    root_locus_map,
    root_locus_plot,
    stability_chart,
    stability_chart_plot,
    step_response,
    time_response_plot,
)
from flycontrol.delay.dcurve import DCurve
from flycontrol.delay.plots.nyquist import modulus_of
from flycontrol.delay.plots.regions import regions_of
from flycontrol.delay.plots.root_locus import path_of
from flycontrol.delay.plots.style import MARK
from flycontrol.errors import InvalidParameterError, NeutralSystemError

b, T = 20.0, 0.0136
PLANT = control.ss([[0, 1], [0, -b]], [[0], [1]], np.eye(2), 0)


def pd(kp=900.0, kd=55.0, lag=T):
    return delay(lag) * np.array([[kp, kd]])


LOOP = pd() * PLANT
CLOSED = feedback(PLANT, pd())
#: s = -k exp(-s): a double root at -1 for k = 1/e, on the axis at +-j pi/2 for k = pi/2
DELAYED_INTEGRATOR = control.tf([1.0], [1.0, 0.0]) * delay(1.0)


@pytest.fixture(autouse=True)
def no_figure_is_left_behind():
    yield
    plt.close("all")


def lines(ax):
    """Lines with more than two points, as pairs of coordinates."""
    return [np.asarray(line.get_xydata()) for line in ax.lines if len(line.get_xydata()) > 2]


def texts(ax):
    return [text.get_text() for text in ax.texts]


def legend_of(ax):
    return ax.get_legend_handles_labels()[1]


def small_chart(**quantities):
    x, y = Axis("kp", "1/s²", np.linspace(-300, 4000, 9)), Axis("kd", "1/s", np.linspace(-40, 200, 8))
    return stability_chart(lambda kp, kd: feedback(PLANT, pd(kp, kd)), x, y, **quantities)


def test_bode_lines_pass_through_the_values_of_the_response():
    found = frequency_response(LOOP, 1.0, 1e3)
    upper, lower = found.plot()
    np.testing.assert_array_equal(lines(upper)[0], np.column_stack([found.omega, found.decibels]))
    np.testing.assert_array_equal(lines(lower)[0], np.column_stack([found.omega, np.degrees(found.phase)]))
    assert [ax.get_ylabel() for ax in (upper, lower)] == ["magnitude [dB]", "phase [deg]"]
    assert lower.get_xlabel() == "angular frequency [rad/s]"


def test_the_pade_response_is_drawn_dashed_beside_the_exact_one():
    omega = np.geomspace(1.0, 1e3, 50)
    upper, lower = bode_plot(LOOP, omega, pade=2)
    assert legend_of(upper) == ["exact", "Padé [2/2]"]
    exact, near = [line for line in lower.lines if len(line.get_xdata()) > 2]
    assert (exact.get_linestyle(), near.get_linestyle()) == ("-", "--")
    # a delay turns by w T; [2/2] has the magnitude 1 and lags less, by the angle of 1 - x^2 / 12 + j x / 2 twice
    x = omega * T
    lag = 2.0 * np.arctan2(x / 2.0, 1.0 - x**2 / 12.0)
    np.testing.assert_allclose(near.get_ydata() - exact.get_ydata(), np.degrees(x - lag), atol=1e-9)


def test_several_systems_and_a_given_approximation_share_the_axes_given():
    figure, panels = plt.subplots(2, 1)
    axes = bode_plot([LOOP, 2.0 * LOOP], ax=panels, approximation=[pade(LOOP, 1), LOOP], label=["a", "b"])
    assert [*axes] == [*panels]
    assert legend_of(axes[0]) == ["a, exact", "a, approximation", "b, exact", "b, approximation"]
    assert plt.get_fignums() == [figure.number]


def test_displayed_margins_are_those_of_the_loop():
    found = margins(LOOP)
    upper, lower = bode_plot(LOOP, display_margins=True)
    assert f"phase margin {np.degrees(found.phase_margin):.3g}°" in upper.get_title()
    bar = next(line for line in lower.lines if line.get_linewidth() > 2.0)
    np.testing.assert_allclose(bar.get_xdata(), found.gain_crossovers[0])
    # linear between points apart by no more than 0.1 in log L: off by less than 0.1^2 / 8 rad
    assert np.diff(bar.get_ydata())[0] == pytest.approx(np.degrees(found.phase_margin), abs=np.degrees(0.00125))


def test_margins_in_the_title_are_marked_at_their_own_crossovers_and_an_unstable_loop_is_called_so():
    """Three times the gain: the lag to spend is nearly a whole turn, and the first phase crossover lies above 1."""
    unstable = 3.0 * LOOP
    found = margins(unstable)
    upper, lower = bode_plot(unstable, display_margins=True)
    assert not found.stable
    assert found.status in upper.get_title()
    assert "unstable" not in bode_plot(LOOP, display_margins=True)[0].get_title()
    (gain_bar,) = [line for line in upper.lines if line.get_color() == MARK]
    (phase_bar,) = [line for line in lower.lines if line.get_color() == MARK]
    assert np.diff(gain_bar.get_ydata())[0] == pytest.approx(-20 * np.log10(found.gain_margin), abs=0.02)
    assert np.diff(phase_bar.get_ydata())[0] == pytest.approx(np.degrees(found.phase_margin), abs=0.1)
    assert phase_bar.get_xdata()[0] == found.gain_crossovers[0]


def test_nyquist_draws_the_whole_contour_counts_and_marks_the_modulus_margin():
    found = nyquist_response(LOOP)
    ax = found.plot()
    drawn = np.concatenate([points for points in lines(ax) if len(points) == len(found.response)])
    for value in found.response[::37]:
        assert np.nanmin(np.hypot(*(drawn - [value.real, value.imag]).T)) == 0.0
    assert "−1 encircled 0 times, P = 0, Z = 0" in ax.get_title()
    radii = {patch.radius for patch in ax.patches if isinstance(patch, Circle)}
    assert radii == {modulus_of(found)}
    # chords of a curve with 8 points a panel: the sagitta is below a thousandth
    assert modulus_of(found) == pytest.approx(margins(LOOP).modulus_margin, rel=1e-3)


def test_an_unstable_loop_has_its_encirclements_in_the_title_and_no_disk():
    ax = nyquist_plot(4.0 * LOOP)
    assert "−1 encircled 2 times clockwise, P = 0, Z = 2" in ax.get_title()
    assert not [patch for patch in ax.patches if isinstance(patch, Circle)]


def test_the_way_around_a_pole_on_the_axis_is_drawn_dotted_as_it_is():
    found = nyquist_response(LOOP)
    beside = found.contour.real > 1e-9
    dotted = next(line for line in found.plot().lines if line.get_label() == "around the pole on the axis")
    drawn = np.asarray(dotted.get_xydata())
    np.testing.assert_array_equal(
        drawn[beside], np.column_stack([found.response[beside].real, found.response[beside].imag])
    )


def test_contours_of_the_nichols_chart_are_those_of_equal_closed_loop_gain():
    ax = nichols_plot(LOOP, pade=3)
    assert legend_of(ax) == ["exact", "Padé [3/3]"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("phase [deg]", "magnitude [dB]")
    levels = []
    for contour in lines(ax)[2:]:
        L = 10.0 ** (contour[:, 1] / 20.0) * np.exp(1j * np.radians(contour[:, 0]))
        decibels = 20.0 * np.log10(np.abs(L / (1.0 + L)))
        np.testing.assert_allclose(decibels, decibels.mean(), atol=1e-8)
        levels.append(round(decibels.mean(), 6))
    assert {12.0, 3.0, 0.0, -6.0, -20.0} <= set(levels)
    known = frequency_response(LOOP, 2.0, 3.0)
    start = lines(nichols_plot(known, grid=False))[0][0]
    np.testing.assert_array_equal(start, [np.degrees(known.phase[0]), known.decibels[0]])
    assert len(lines(nichols_plot(LOOP, grid=False))) == 1


def test_no_decade_of_an_asymptote_fills_the_bode_diagram_but_what_is_asked_for_is_shown():
    _, lower = frequency_response(LOOP).plot()
    start = lower.get_xlim()[0]
    w = np.geomspace(1.0, 100.0, 10_000)
    turned = np.arctan(55.0 * w / 900.0) - np.arctan(w / b) - w * T
    first = w[np.argmax(np.abs(turned) > np.radians(1.0))]
    assert start == pytest.approx(0.1 * first, rel=0.1)  # points of the response are apart by at most 0.1 in log L
    assert bode_plot(LOOP, omega_limits=(1e-3, 1e2))[1].get_xlim() == pytest.approx((1e-3, 1e2))


def test_a_locus_says_how_many_branches_its_picture_leaves_out_and_leaves_out_no_crossing():
    locus = root_locus_map(DELAYED_INTEGRATOR, np.linspace(0.1, 2.0, 12), 6)
    ax = locus.plot()
    outside = sum(
        not any(
            abs(root.imag) <= ax.get_ylim()[1] and root.real >= ax.get_xlim()[0] for root in branch[np.isfinite(branch)]
        )
        for branch in locus.branches
    )
    assert outside > 0
    assert f"{outside} of {len(locus.branches)} branches lie outside this picture" in texts(ax)
    assert ax.get_ylim()[1] > locus.crossings[0].frequency
    assert ax.get_xlim()[0] < -1.0  # the collision


def test_the_unstable_half_plane_is_tinted_as_in_the_report():
    for ax in (pole_plot(CLOSED), root_locus_plot(DELAYED_INTEGRATOR, [0.5, 1.0, 2.0], count=3)):
        tinted = [patch.get_extents().transformed(ax.transData.inverted()) for patch in ax.patches]
        assert [box.x0 for box in tinted] == pytest.approx([0.0], abs=1e-9)


def test_the_nyquist_curve_of_an_integrator_is_no_strip():
    ax = nyquist_plot(LOOP)
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    assert (high - low) / (right - left) < 1.7


def test_the_gang_of_four_stands_as_in_python_control():
    P, C = control.tf([1.0], [1.0, b, 0.0]), control.tf([55.0, 900.0], [0.001, 1.0]) * delay(T)
    axes = gangof4_plot(P, C, omega=[1.0, 10.0, 100.0], pade=2)
    four = gangof4(P, C)
    for ax, G in zip(axes.flat, (four.T, four.PS, four.CS, four.S), strict=True):
        expected = 20.0 * np.log10(np.abs(G(1j * np.array([1.0, 10.0, 100.0]))[:, 0, 0]))
        np.testing.assert_allclose(lines(ax)[0][:, 1], expected, atol=1e-9)
    assert axes.shape == four.plot().shape == (2, 2)


def test_poles_are_where_the_spectrum_has_them_and_the_certified_line_is_drawn():
    found = pole_map(CLOSED, 8)
    ax = found.plot(approximation=pade(CLOSED, 3))
    exact, near = (np.asarray(line.get_xydata()) for line in ax.lines[:2])
    np.testing.assert_array_equal(exact, np.column_stack([found.roots.real, found.roots.imag]))
    rational = rightmost_roots(pade(CLOSED, 3), 8).roots
    np.testing.assert_allclose(
        near[: len(rational)], np.column_stack([rational.real, rational.imag]), rtol=1e-9, atol=1e-9
    )
    line = next(line for line in ax.lines if line.get_label() == "complete right of this line, certified")
    assert set(line.get_xdata()) == {found.line}
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("real part [1/s]", "imaginary part [rad/s]")


def test_branches_pass_through_their_crossings_and_collisions():
    locus = root_locus_map(DELAYED_INTEGRATOR, np.linspace(0.1, 2.0, 12), 4)
    ax = locus.plot(parameter="k")
    crossing, collision = locus.crossings[0], locus.collisions[0]
    assert crossing.value == pytest.approx(np.pi / 2, rel=1e-9)
    assert collision.root == pytest.approx(-1.0, abs=1e-6)
    assert 1j * crossing.frequency in path_of(locus, crossing.branch)
    assert all(complex(collision.root) in path_of(locus, branch) for branch in collision.branches)
    markers = {line.get_marker(): np.asarray(line.get_xydata()) for line in ax.lines}
    np.testing.assert_allclose(markers["o"], [[0.0, np.pi / 2], [0.0, -np.pi / 2]], atol=1e-9)
    np.testing.assert_allclose(markers["D"], [[-1.0, 0.0]], atol=1e-6)
    assert "k = 1.571, 1.57 rad/s" in texts(ax)


def test_a_family_and_its_pade_approximation_have_two_loci():
    ax = root_locus_plot(lambda lag: feedback(PLANT, pd(lag=lag)), [0.01, 0.02, 0.03], pade=2, count=3)
    assert legend_of(ax)[:2] == ["exact", "Padé [2/2]"]


@pytest.mark.parametrize("respond", [step_response, impulse_response, lambda G, t: initial_response(G, t, [0.1, 0.0])])
def test_time_responses_pass_through_their_samples_and_pade_repeats_the_experiment(respond):
    found = respond(CLOSED, 0.2)
    axes = found.plot(pade=6)
    assert axes.shape == (2, 1)
    outputs, again = found.outputs.reshape(2, -1), found.approximated(6)
    for i, ax in enumerate(axes[:, 0]):
        exact = lines(ax)[0]
        np.testing.assert_array_equal(exact[np.isin(exact[:, 0], found.time), 1], outputs[i])
        near = lines(ax)[1]
        np.testing.assert_array_equal(near[np.isin(near[:, 0], found.time), 1], again.outputs.reshape(2, -1)[i])
    assert axes[1, 0].get_xlabel() == "time [s]"


@pytest.mark.parametrize("respond", [step_response, lambda G, t: initial_response(G, t, [0.1, 0.0])])
def test_the_repeated_experiment_starts_from_the_same_constant_past(respond):
    """[6/6] follows the delay of these slow outputs; had its channels been empty at first, nothing would hold it."""
    found = respond(CLOSED, 0.2)
    outputs = found.outputs.reshape(2, -1)
    error = np.abs(found.approximated(6).outputs.reshape(2, -1) - outputs).max(axis=1)
    assert (error < 2e-3 * np.abs(outputs).max(axis=1)).all()


def test_a_jump_is_drawn_as_a_jump_and_an_impulse_as_an_arrow():
    stepped = lines(step_response(delay(0.1), 0.3).plot()[0, 0])[0]
    rise = np.flatnonzero(np.diff(stepped[:, 1]) > 0.5)
    assert len(rise) == 1
    np.testing.assert_allclose(stepped[rise[0] : rise[0] + 2, 0], 0.1, atol=1e-9)
    assert "1 δ" in texts(impulse_response(delay(0.1), 0.3).plot()[0, 0])


def test_a_time_response_can_still_be_sent_to_another_process():
    found = pickle.loads(pickle.dumps(step_response(CLOSED, 0.1)))
    np.testing.assert_array_equal(found.approximated(4).outputs, step_response(pade(CLOSED, 4), 0.1).outputs)


def test_a_chart_shows_its_boundary_and_the_number_of_roots_of_each_region():
    chart = small_chart(quantities=["decay_rate", "boundary"])
    ax = chart.plot()
    assert {"0", "2"} <= set(texts(ax)) <= {"0", "1", "2", "3"}
    drawn = lines(ax)
    for curve, line in zip(chart.boundary, drawn, strict=True):
        np.testing.assert_array_equal(line, np.column_stack([curve.x, curve.y]))
        if not curve.static:
            gains = pd_boundary(b, T, curve.omega)
            np.testing.assert_allclose(line, np.column_stack([gains.kp, gains.kd]), rtol=1e-6, atol=1e-3)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("kp [1/s²]", "kd [1/s]")
    assert any(other.get_ylabel() == "decay rate [1/s]" for other in ax.figure.axes)


def test_shading_ends_on_the_exact_boundary_and_every_region_has_its_number():
    """Pixels against the closed form for PD: stable for kp > 0, b + kd > 0 and a delay below the largest stable one."""
    x, y = Axis("kp", "1/s²", np.linspace(-1500, 14000, 9)), Axis("kd", "1/s", np.linspace(-80, 260, 8))
    chart = stability_chart(lambda kp, kd: feedback(PLANT, pd(kp, kd)), x, y, ["boundary"])
    found = regions_of(chart)
    assert sorted(region.unstable_roots for region in found.regions) == [0, 1, 2, 3]
    size = len(found.unstable_roots)
    kp, kd = np.meshgrid(np.linspace(-1500, 14000, size), np.linspace(-80, 260, size))
    with np.errstate(invalid="ignore"):
        half = (kd**2 - b**2) / 2
        wc = np.sqrt(half + np.sqrt(half**2 + kp**2))
        largest = (np.arctan2(kd * wc, kp) + np.arctan2(b, wc)) / wc
    stable = (kp > 0) & (b + kd > 0) & (largest > T)
    wrong = (found.unstable_roots == 0) != stable
    depth = scipy.ndimage.distance_transform_edt(stable) + scipy.ndimage.distance_transform_edt(~stable)
    assert depth[wrong].max(initial=0.0) <= 2.5  # pixels: two of a curve's own width and rounding
    assert set(texts(chart.plot())) == {"0", "1", "2", "3"}


def test_a_region_too_narrow_for_the_grid_is_not_guessed():
    unstable = np.array([[1, 1, 0, 0], [1, 1, 0, 0], [1, 1, 0, 0], [1, 1, 0, 0]])
    y = np.linspace(0.0, 3.0, 50)
    curves = tuple(DCurve(np.full(50, at), y, np.zeros(50)) for at in (1.3, 1.6))
    grid = np.arange(4.0)
    chart = StabilityChart(x=Axis("a", "", grid), y=Axis("b", "", grid), unstable_roots=unstable, boundary=curves)
    assert [region.unstable_roots for region in regions_of(chart).regions] == [-1, 0, 1]
    assert sorted(texts(chart.plot())) == ["0", "1", "?"]


def test_another_charts_boundary_is_drawn_dashed():
    chart = small_chart()
    ax = stability_chart_plot(chart, approximation=chart)
    assert legend_of(ax) == ["approximation"]
    assert len(chart.plot("unstable_roots").figure.axes) == 1


def test_no_setting_of_matplotlib_changes_and_given_axes_are_used():
    before = mpl.rcParams.copy()
    _, ax = plt.subplots()
    assert nyquist_plot(LOOP, ax=ax) is ax
    assert pole_plot(CLOSED, ax=ax) is ax
    assert small_chart(quantities=["boundary"]).boundary[0].plot(ax=ax) is ax
    assert response(CLOSED, 0.1, [0.0], [[1.0]]).plot(ax=[ax, plt.figure().subplots()])[0, 0] is ax
    assert mpl.rcParams == before


SLICE = StabilityChart(x=Axis("k", "", [1.0]), y=Axis("T", "s", [0.1, 0.2]), unstable_roots=np.zeros((2, 1), dtype=int))

NOT_TO_BE_DRAWN = [
    (lambda: bode_plot(PLANT), "one input and one output"),
    (lambda: bode_plot([]), "nothing to draw"),
    (lambda: bode_plot("loop"), "got str"),
    (lambda: bode_plot(LOOP, [3.0, 1.0]), "rising"),
    (lambda: bode_plot(LOOP, omega_limits=(1.0,)), "a lowest and a highest one"),
    (lambda: bode_plot([LOOP, LOOP], approximation=LOOP), "2 exact result.s. need as many approximations, got 1"),
    (lambda: bode_plot([LOOP, LOOP], label="a"), "as many labels, got 1"),
    (lambda: bode_plot(LOOP, ax=plt.figure().subplots()), "2 x 1 panels and needs as many axes in `ax`, got 1"),
    (lambda: bode_plot([LOOP, LOOP], display_margins=True), "Margins are displayed for one system"),
    (lambda: frequency_response(LOOP).plot(pade=3), "FrequencyResponse holds no system that could be approximated"),
    (lambda: nyquist_response(LOOP).plot(pade=3), "NyquistResponse holds no system that could be approximated"),
    (lambda: gangof4_plot(LOOP), "needs a plant and a controller"),
    (lambda: root_locus_plot(LOOP), "needs the gains"),
    (lambda: root_locus(lambda k: feedback(k * LOOP), [0.5, 1.0], 2).plot(pade=2), "RootLocus holds no system"),
    (lambda: time_response_plot(LOOP), "compute step_response"),
    (lambda: response(CLOSED, 1.0).plot(pade=2), "cannot be repeated on a Padé"),
    (
        lambda: initial_response(CLOSED, 1.0, history=lambda t: [0.1, 0.0]).plot(pade=2),
        "whose states know no history",
    ),
    (lambda: time_response_plot([step_response(CLOSED), step_response(delay(0.1))]), r"\(2, 1\), \(1, 1\)"),
    (lambda: stability_chart_plot(SLICE), "is a slice"),
    (lambda: small_chart().plot("decay_rate"), "has no 'decay_rate' to draw, only unstable_roots"),
]


@pytest.mark.parametrize(("draw", "sentence"), NOT_TO_BE_DRAWN)
def test_what_cannot_be_drawn_is_refused_in_a_sentence(draw, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        draw()


def test_a_neutral_system_has_no_picture_of_its_poles():
    with pytest.raises(NeutralSystemError, match="neutral type"):
        pole_plot(feedback(0.5 * delay(0.1)))
