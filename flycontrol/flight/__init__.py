"""The wing level: forces and torques of flapping wings, and the flights of body and wings that follow from them."""
