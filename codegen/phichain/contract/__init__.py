"""The contract: what every generated folder promises, said once, and read by whoever keeps it."""
