"""``python -m benchmarks.front_door``."""

import sys

from benchmarks.front_door import main

if __name__ == "__main__":
    sys.exit(main())
