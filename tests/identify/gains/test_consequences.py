"""A fit's uncertainty carried into margins, poles and recovery."""

import numpy as np
import pytest
from perturbed_fly import AT_REST, recording

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.bootstrap import bootstrap
from flycontrol.identify.gains.consequences import consequences, of_any_loop
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
from flycontrol.model.gains import PulseTask
from flycontrol.model.stability import assess
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

TASK = PulseTask(duration=4.5 * ms, peak=20 * deg, tolerance=2 * deg)


@pytest.fixture(scope="module")
def found():
    return fit_gains([recording(0)], gain_model(fixed=AT_REST))


@pytest.fixture(scope="module")
def cloud(found):
    return consequences(found, TASK, 200)


def test_every_interval_holds_what_the_estimate_does(found, cloud):
    own = assess(found.loop(), TASK)
    inside = {
        "gain_margin": own.margins.gain_margin, "phase_margin": own.margins.phase_margin,
        "delay_margin": own.margins.delay_margin, "modulus_margin": own.margins.modulus_margin,
        "recovery_time": own.recovery_time, "abscissa": own.poles[0].real,
    }  # fmt: skip
    for name, value in inside.items():
        low, high = cloud.interval(name)
        assert low < value < high, name


def test_each_draw_is_judged_as_its_loop_would_be(cloud):

    b, kp, kd, delay, _ = cloud.loops[7]
    own = assess(YawLoop.from_rates(b=b, kp=kp, kd=kd, delay=delay), TASK)
    assert cloud.recovery_time[7] == pytest.approx(own.recovery_time, rel=1e-6)
    assert cloud.modulus_margin[7] == pytest.approx(own.margins.modulus_margin, rel=1e-6)
    margins = (cloud.gain_margin[7], cloud.phase_margin[7], cloud.delay_margin[7])
    exact = (own.margins.gain_margin, own.margins.phase_margin, own.margins.delay_margin)
    assert margins == pytest.approx(exact, rel=1e-9)
    assert cloud.abscissa[7] == pytest.approx(own.poles[0].real, rel=1e-9)


def test_the_cloud_has_the_covariance_of_the_fit(found, cloud):
    spread = cloud.loops[:, :4].std(axis=0) / [found[k].standard_error for k in ("damping", "kp", "kd", "delay")]
    assert np.abs(spread - 1).max() < 4 / np.sqrt(2 * 200)


def test_no_draw_of_a_well_known_loop_is_unstable_and_some_of_an_edgy_one_are(cloud):
    assert cloud.unstable == 0
    edgy = fit_gains(
        [recording(0, noise=3.0, truth={"kp": 7000.0, "kd": 112.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0})],
        gain_model(fixed=AT_REST | {"damping": 69.0}),
    )
    drawn = consequences(edgy, TASK, 100)
    assert np.isnan(drawn.recovery_time).mean() == drawn.unstable
    assert ((drawn.abscissa > 0).mean()) == pytest.approx(drawn.unstable)


def test_a_bootstrap_can_be_carried_too(found):
    boot = bootstrap(found, 20)
    np.testing.assert_allclose(consequences(found, TASK, boot=boot).loops[:, 1], boot.draws[:, 0] - found["kp"].bias)


def test_an_unknown_quantity_is_refused(cloud):
    with pytest.raises(InvalidParameterError, match="An interval needs one of gain_margin"):
        cloud.interval("speed")


def test_the_general_code_for_integral_terms_agrees_with_the_closed_forms_as_the_term_vanishes(cloud):
    loops = cloud.loops[:4].copy()
    loops[:, 4] = 1e-6 * loops[:, 1]
    found = of_any_loop(loops, TASK)
    exact = np.column_stack([
        cloud.gain_margin, cloud.phase_margin, cloud.delay_margin, cloud.modulus_margin, cloud.recovery_time,
    ])[:4]  # fmt: skip
    np.testing.assert_allclose(found, exact, rtol=1e-5)


def test_an_integral_controller_has_margins_and_intervals_too():
    found = fit_gains([recording(0, noise=0.1)], gain_model("PID", fixed=AT_REST | {"damping": 69.0}))
    drawn = consequences(found, TASK, 40)
    own = assess(found.loop(), TASK)
    assert drawn.loops[:, 4].std() > 0
    low, high = drawn.interval("delay_margin")
    assert low < own.margins.delay_margin < high
