"""Whether films, cameras and fly belong together."""
