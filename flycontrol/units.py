"""Units at the door: multiply on the way in, divide on the way out. Inside, everything is SI and radians.

>>> from flycontrol.units import ms
>>> delay = 13.6 * ms
"""

from math import pi

ms = 1e-3  #: millisecond [s]
us = 1e-6  #: microsecond [s]
deg = pi / 180.0  #: degree [rad]
mm = 1e-3  #: millimetre [m]
um = 1e-6  #: micrometre [m]
mg = 1e-6  #: milligram [kg]
ug = 1e-9  #: microgram [kg]
Hz = 1.0  #: hertz [1/s]
nN_m = 1e-9  #: nanonewton metre [N m]
