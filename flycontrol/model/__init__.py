"""What a fly and an experiment are: the yaw loop, its parameters, wing motion, recordings, and what follows from them."""
