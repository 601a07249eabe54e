"""What a fly and an experiment are: yaw loop, parameters, wing motion, recordings, and what follows from them."""
