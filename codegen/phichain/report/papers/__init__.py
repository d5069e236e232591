"""What only figures of the two papers draw."""
