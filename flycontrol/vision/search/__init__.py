"""Where a fly is looked for, and whether it is believed to be there."""
