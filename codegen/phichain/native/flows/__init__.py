"""The emitted flows as Python callables."""
