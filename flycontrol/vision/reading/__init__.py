"""What a visual hull says of body and wings by itself."""
