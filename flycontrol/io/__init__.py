"""The door: read, check, refuse. Units become SI here."""
