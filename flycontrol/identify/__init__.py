"""From recordings to parameters, with intervals."""
