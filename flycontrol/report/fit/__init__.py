"""The page and files of fitted gains."""
