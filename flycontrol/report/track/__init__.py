"""The page and files of a tracked flight."""
