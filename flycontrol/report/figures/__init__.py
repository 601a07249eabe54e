"""One figure a file, each from a part of a study; they draw and compute nothing."""
