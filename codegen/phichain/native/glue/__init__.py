"""C that is compiled beside a generated folder's own: loops over rows, and twins that Ctrl-C can leave."""
