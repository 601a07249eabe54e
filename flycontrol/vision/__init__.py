"""Vision: from silhouettes of a fly to its visual hull and its motion."""
