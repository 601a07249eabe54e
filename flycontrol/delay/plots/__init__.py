"""Pictures of results, named and called as python-control's: exact results solid, approximations dashed beside them.

Every function takes a result or the system it is computed from, or a list of these, draws into `ax` or a new figure of
pyplot's, and returns the axes. Nothing is shown and no setting of matplotlib's is changed; matplotlib itself is
imported when something is drawn.
"""

from flycontrol.delay.plots.bode import bode_plot
from flycontrol.delay.plots.chart import d_curve_plot, stability_chart_plot
from flycontrol.delay.plots.gangof4 import gangof4_plot
from flycontrol.delay.plots.nichols import nichols_plot
from flycontrol.delay.plots.nyquist import nyquist_plot
from flycontrol.delay.plots.poles import pole_map, pole_plot
from flycontrol.delay.plots.root_locus import root_locus_map, root_locus_plot
from flycontrol.delay.plots.time_response import time_response_plot

__all__ = [
    "bode_plot",
    "d_curve_plot",
    "gangof4_plot",
    "nichols_plot",
    "nyquist_plot",
    "pole_map",
    "pole_plot",
    "root_locus_map",
    "root_locus_plot",
    "stability_chart_plot",
    "time_response_plot",
]
