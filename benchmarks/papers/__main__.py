"""``python -m benchmarks.papers``."""

from benchmarks.papers import main

if __name__ == "__main__":
    main()
