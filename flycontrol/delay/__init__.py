"""Exact theory of linear systems with delays, for any plant: nothing here knows a fly."""
