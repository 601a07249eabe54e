"""Control engineering for insect flight, and exact control theory for loops with a reaction delay."""
