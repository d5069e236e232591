"""Riccati equations: solved by doubling, refined by Newton's steps, in doubles and in twice their digits."""
