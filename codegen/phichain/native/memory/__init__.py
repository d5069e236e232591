"""Memory that C reads and writes: arrays on their way there, and the runtime parameters."""
