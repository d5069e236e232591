"""What a call from Python costs."""
