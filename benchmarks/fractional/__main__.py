"""``python -m benchmarks.fractional``."""

from benchmarks.fractional import main

if __name__ == "__main__":
    main()
