"""Compiled inner loops (Numba): the march of a time response, and Newton's method on the characteristic equation."""
