import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.io.parameters import read_parameters
from flycontrol.model.gain_plane import delay_slice, gain_plane
from flycontrol.model.gains import ChosenGains, largest_stable_delay
from flycontrol.model.loci import delay_locus, gain_locus
from flycontrol.model.loop_shape import loop_shape
from flycontrol.model.recovery import pulse_response, recovery_curve
from flycontrol.model.stability import assess
from flycontrol.model.study import DampingRow, StabilityStudy, YawRecoveries
from flycontrol.report.nominal import pulse_task, yaw_loop
from flycontrol.report.provenance import provenance
from flycontrol.units import deg

_WRITE = """
import sys
from pathlib import Path
from flycontrol.io.parameters import read_parameters
from flycontrol.report.page import write_report
write_report(read_parameters(), None, Path(sys.argv[1]), command="flycontrol report")
"""


@pytest.fixture(scope="session")
def parameters():
    return read_parameters()


@pytest.fixture(scope="session")
def unstable_parameters(parameters):
    higher = {
        "proportional_gain": replace(parameters.proportional_gain, value=9050.0, text="9050 1/s^2"),
        "derivative_gain": replace(parameters.derivative_gain, value=145.0, text="145 1/s"),
    }
    return replace(parameters, **higher)


@pytest.fixture(scope="session")
def origin(parameters):
    return provenance(parameters, "flycontrol report", None)


@pytest.fixture(scope="session")
def stable(parameters):
    return quick_study(parameters)


@pytest.fixture(scope="session")
def studied():
    """From a fly's parameters to a study of it."""
    return quick_study


@pytest.fixture(scope="session")
def unstable(unstable_parameters):
    return quick_study(unstable_parameters)


@pytest.fixture(scope="session")
def fresh_reports(tmp_path_factory):
    """Folders of two reports on the published fly, written by two processes that hash strings differently."""
    folders = [tmp_path_factory.mktemp("report") / "yaw" for _ in range(2)]
    for seed, folder in enumerate(folders):
        environment = os.environ | {"PYTHONHASHSEED": str(seed)}
        subprocess.run([sys.executable, "-c", _WRITE, str(folder)], check=True, env=environment)
    return folders


def quick_study(parameters):
    """The parts of a study without the long search for the best P and PD, whose rows are made up here."""
    loop, task = yaw_loop(parameters), pulse_task(parameters)
    result = assess(loop, task)
    b, kp, kd = loop.plant.damping_rate, loop.kp, loop.kd
    return StabilityStudy(
        result=result,
        closed_form_largest_delay=largest_stable_delay(b, kp, kd),
        shape=loop_shape(loop, 4, turn=0.1),
        gain_locus=gain_locus(loop),
        delay_locus=delay_locus(loop),
        plane=gain_plane(loop),
        delay_slice=delay_slice(loop),
        recoveries=_recoveries(result) if result.stable else None,
        curve=recovery_curve(loop, task.duration, np.linspace(2.1, 45, 80) * deg) if result.stable else None,
        pade_poles={n: rightmost_roots(loop.pade_closed_loop(n)).roots for n in (1, 2, 4)},
        damping_table=[_row(b, 0.099, 0.050), _row(120.0, 0.073, 0.042), _row(176.0, 0.0617, 0.0376)],
        deadline=0.060,
        proportional_suffices_from=189.4,
    )


def _recoveries(result):
    peaks, time = np.array([5.0, 20.0, 40.0]) * deg, np.linspace(0, 0.1, 400)
    exact, approximate = (
        pulse_response(system, result.pulse, 0.1)(time)
        for system in (result.loop.closed_loop(), result.loop.pade_closed_loop(4))
    )
    factor = (peaks / result.task.peak)[:, None]
    return YawRecoveries(
        time=time, peaks=peaks, yaw=factor * exact[0], yaw_pade=factor * approximate[0],
        torque=factor * exact[2] / result.loop.plant.inertia, pade_order=4,
    )  # fmt: skip


def _row(b, slow, fast):
    p = ChosenGains(rule="made up", kp=1500.0, kd=0.0, recovery_time=slow, nearby=0.145, modulus_margin=0.63)
    pd = ChosenGains(rule="made up", kp=3480.0, kd=54.0, recovery_time=fast, nearby=np.inf, modulus_margin=0.5)
    return DampingRow(b=b, proportional=p, derivative=pd)
