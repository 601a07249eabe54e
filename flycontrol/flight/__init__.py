"""The wing level: forces and torques of flapping wings."""
