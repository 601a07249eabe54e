"""The door: read, check, refuse. Files and units stop here; inside, everything is SI and radians."""
