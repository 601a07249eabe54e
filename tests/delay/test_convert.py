import subprocess
import sys

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay import delay, from_control, named, static_gain, to_statespace
from flycontrol.delay.convert import as_delay_lti
from flycontrol.errors import InvalidParameterError

POINTS = random_points(3)


def entrywise(numerators, denominators):
    """Transfer matrix at POINTS, from polynomials."""
    rows = [
        [np.polyval(num, POINTS) / np.polyval(den, POINTS) for num, den in zip(nums, dens, strict=True)]
        for nums, dens in zip(numerators, denominators, strict=True)
    ]
    return np.moveaxis(np.array(rows), -1, 0)


@drawn_alike
@given(st.integers(0, 2**32 - 1))
def test_a_transfer_matrix_of_python_control_keeps_every_entry(seed):
    """Proper entries of any degree, zero and constant ones included; python-control needs Slycot for this."""
    rng = np.random.default_rng(seed)
    p, m = rng.integers(1, 4, size=2)
    dens = [
        [np.atleast_1d(np.poly(-rng.uniform(0.5, 3.0, size=rng.integers(0, 4)))) * rng.uniform(1, 2) for _ in range(m)]
        for _ in range(p)
    ]
    nums = [[rng.normal(size=rng.integers(1, len(den) + 1)) * (rng.uniform() > 0.2) for den in row] for row in dens]
    converted = from_control(control.tf(nums, dens))
    expected = entrywise(nums, dens)
    np.testing.assert_allclose(converted(POINTS), expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max())


def test_poles_that_a_column_or_a_row_shares_become_states_once():
    den = [1.0, 3.0, 5.0]
    column = from_control(control.tf([[[1.0]], [[1.0, 0.0]]], [[den], [den]]))
    row = from_control(control.tf([[[1.0], [1.0, 0.0]]], [[den, den]]))
    assert column.n_states == row.n_states == 2
    np.testing.assert_allclose(row(POINTS), entrywise([[[1.0], [1.0, 0.0]]], [[den, den]]), rtol=1e-12)


def test_states_of_a_transfer_function_are_scaled_to_each_other():
    """1 / (s + 1000)^3 in companion form has entries from 1 to 1e9."""
    converted = from_control(control.tf([1e9], np.poly([-1e3] * 3)))
    sizes = np.abs(converted.A[converted.A != 0])
    assert sizes.max() / sizes.min() < 1e2
    s = 1e3 * POINTS
    np.testing.assert_allclose(converted(s)[:, 0, 0], 1e9 / (s + 1e3) ** 3, rtol=1e-12)


def test_names_come_along_both_ways_and_names_that_python_control_made_up_stay_there():
    P = control.ss(
        random_system(1, 2, 0).A, [[1.0], [0.0]], np.eye(2), 0, inputs="torque", outputs=["angle", "rate"], name="P"
    )
    converted = from_control(P)
    assert (converted.name, converted.input_names, converted.output_names) == ("P", ("torque",), ("angle", "rate"))
    back = to_statespace(converted)
    assert (back.name, back.input_labels, back.output_labels) == ("P", ["torque"], ["angle", "rate"])
    anonymous = from_control(control.tf([1.0], [1.0, 1.0]))
    assert (anonymous.name, anonymous.input_names, anonymous.output_names) == ("", (), ())
    assert to_statespace(named(delay(0.1), inputs="u", name="late"), 3).input_labels == ["u"]


def test_an_improper_entry_is_refused_by_its_place_and_with_the_way_out():
    G = control.tf([[[1.0], [1.0, 0.0, 0.0]]], [[[1.0, 1.0], [1.0, 1.0]]])
    with pytest.raises(
        InvalidParameterError, match=r"input 1 to output 0 is improper.*degree 2.*degree 1.*derivative output"
    ):
        from_control(G)
    with pytest.raises(InvalidParameterError, match="multiply by the plant first"):
        control.tf([1.0, 0.0], [1.0]) * delay(0.1)


@pytest.mark.parametrize(
    ("stranger", "sentence"),
    [
        (control.tf([1.0], [1.0, 0.5], dt=0.1), "Only continuous-time systems"),
        (control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], dt=True), "Only continuous-time systems"),
        (control.frd([1.0, 2.0], [1.0, 2.0]), "combine the numbers instead"),
        (control.nlsys(None, lambda t, x, u, params: u, inputs=1, outputs=1), "NonlinearIOSystem; linearise it first"),
    ],
)
def test_systems_that_are_not_linear_in_continuous_time_are_refused(stranger, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        as_delay_lti(stranger)
    with pytest.raises(InvalidParameterError, match=sentence):
        delay(0.1) * stranger


def test_frequency_response_data_on_the_left_are_refused_by_python_control():
    with pytest.raises(TypeError, match="FRD"):
        control.frd([1.0, 2.0], [1.0, 2.0]) * delay(0.1)


def test_a_gain_without_states_goes_to_python_control_and_back():
    gain = static_gain([[1.0, 2.0, 3.0]])
    assert from_control(to_statespace(gain)).D11.tolist() == [[1.0, 2.0, 3.0]]


def test_importing_the_package_loads_nothing_and_using_a_name_loads_what_it_needs():
    heavy = "[name for name in ('numpy', 'numba', 'control', 'matplotlib') if name in sys.modules]"
    script = (
        f"import sys, flycontrol.delay; print({heavy}); import flycontrol.delay.pade; "
        f"from flycontrol.delay import pade, delay; pade(2 * delay(0.1), 3); print({heavy})"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert said.stdout.split("\n")[:2] == ["[]", "['numpy']"]
