"""Compiled inner loops of the wing level."""
