"""The figures on flies that are not pooled, each with a caption that states what it shows."""

from __future__ import annotations

from matplotlib.figure import Figure

from flycontrol.identify.gains.apart import ApartStudy
from flycontrol.report.figures.apart import recoveries_apart
from flycontrol.report.figures.fit_flies import MOST, fits_compared
from flycontrol.report.page_figures import PageFigure
from flycontrol.report.style import svg


def apart_figures(study: ApartStudy) -> dict[str, PageFigure]:
    """Draw every figure that the members have parts for, by name."""
    drawn = [_fits(study), _recoveries(study)]
    return {figure.name: figure for figure in drawn if figure is not None}


def _page_figure(name: str, figure: Figure, title: str, caption: str) -> PageFigure:
    return PageFigure(name=name, title=title, caption=caption, drawing=svg(figure, name, title))


def _fits(study: ApartStudy) -> PageFigure | None:
    count = sum(fit.usable for fit in study.group.fits)
    if not count:
        return None
    which = f"The first {MOST} of {count} {study.plural}" if count > MOST else f"Each {study.by}"
    mean = (
        " Diamond: the mean over them, with an interval that carries the spread between them." if study.effects else ""
    )
    caption = f"{which} by itself, {100 * study.level:g} % intervals by the covariance.{mean}"
    figure = fits_compared(study.group.fits, {}, study.effects, study.level)
    return _page_figure("fits", figure, f"Every {study.by} by itself", caption)


def _recoveries(study: ApartStudy) -> PageFigure | None:
    found = [(member.name, recovery) for member in study.members if (recovery := member.study.recovery) is not None]
    if not found:
        return None
    caption = (
        f"Lines: what each {study.by}’s own estimates predict; marks of the same look: its recordings, with intervals; "
        "marks at the upper edge: not recovered in the recording."
    )
    return _page_figure("recoveries", recoveries_apart(found), "Recovery time against strength", caption)
