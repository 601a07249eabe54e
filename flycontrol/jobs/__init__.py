"""Long work and its files: what is written is written whole or not at all."""
