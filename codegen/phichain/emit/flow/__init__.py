"""C around Programs: what runs over many steps or many states."""
