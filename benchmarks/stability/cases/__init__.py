"""The cases of the stability table: what one is, the committed ones, and ours by kind of work."""
