"""Figures and pages: they compose and draw what other layers computed."""
