"""Compiled inner loops of carving and drawing."""
