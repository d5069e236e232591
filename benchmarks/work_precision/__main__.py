"""``python -m benchmarks.work_precision``."""

import sys

from benchmarks.work_precision import main

if __name__ == "__main__":
    sys.exit(main())
