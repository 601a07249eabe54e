"""The page on flies that were fitted apart."""
