"""``python -m benchmarks.stability``."""

import sys

from benchmarks.stability import main

if __name__ == "__main__":
    sys.exit(main())
