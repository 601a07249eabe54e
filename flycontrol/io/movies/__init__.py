"""Films of an animal as laboratories keep them: stills, stacks, arrays, sparse MATLAB movies, video."""
