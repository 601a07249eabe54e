"""Where the phase at the gain crossover goes, link by link around the loop."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from flycontrol.delay.margins import Margins
from flycontrol.model.chain import Chain
from flycontrol.report.style import EXACT, GUIDE_LINE, MARK, PADE, in_house_style, new_figure
from flycontrol.units import deg


@in_house_style()
def phase_budget(chain: Chain, margins: Margins) -> Figure:
    """Waterfall of the phase [deg] of each link at the gain crossover, ending where the phase margin begins."""
    figure = new_figure(2.7)
    ax = figure.subplots()
    steps = budget(chain, float(margins.gain_crossovers[-1]))
    start = 0.0
    for row, phase in enumerate(phase for _, phase in steps):
        ax.barh(row, phase, left=start, color=EXACT if phase < 0 else PADE, height=0.55)
        ax.plot([start + phase] * 2, [row, row + 1], **GUIDE_LINE)
        ax.text(max(start, start + phase) + 3, row, f"{phase:+.1f}°".replace("-", "−"), va="center")
        start += phase
    last = len(steps)
    ax.barh(last, -180 - start, left=start, color="white", edgecolor=MARK, linewidth=1.4, height=0.55)
    ax.text(start + 3, last, f"phase margin {start + 180:.1f}°", va="center", color=MARK)
    ax.axvline(-180, color=MARK, linewidth=0.9)
    ax.axvline(0, **GUIDE_LINE)
    ax.set_yticks(range(last + 1), [name for name, _ in steps] + ["left until −180°"])
    ax.invert_yaxis()
    ax.set_xlim(-195, 130)
    ax.set_xticks(np.arange(-180, 91, 45))
    ax.set_xlabel("phase, summed around the loop [deg]")
    return figure


def budget(chain: Chain, omega: float) -> list[tuple[str, float]]:
    """Name and phase [deg] of each link at omega [rad/s] that turns the signal, a delay apart from its link."""
    steps: list[tuple[str, float]] = []
    for link, phase in zip(chain.links, chain.phase_budget(omega).values(), strict=True):
        late = omega * link.delay / deg
        name = link.name.partition(" (")[0]
        steps.append((name + (", without delay" if late else ""), phase / deg + late))
        if late:
            steps.append(("reaction delay", -late))
    return [(name, phase) for name, phase in steps if abs(phase) > 1e-9]
