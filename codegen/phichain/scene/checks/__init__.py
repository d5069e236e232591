"""What the values of a scene are held to, key by key."""
