"""From the wing level to the reduced yaw model: its coefficients, what they are made of, and how far they hold."""
