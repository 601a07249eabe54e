"""The page and files of a simulated flight."""
