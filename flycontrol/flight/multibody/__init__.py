"""Body and two wings as linked rigid bodies: what is free, what drives it, forward and inverse dynamics."""
