"""Gains, delay and what they mean, from recordings of perturbed flies."""
