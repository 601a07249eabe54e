"""Splines through uncertain curves and turns."""
